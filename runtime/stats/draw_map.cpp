#include "runtime/stats/draw_map.h"

#include <algorithm>
#include <cassert>
#include <sstream>

namespace cairn {
namespace {

constexpr double kPicture = 640;
constexpr double kMargin = 24;

GeoBounds bounds_of(const SceneMap& map) {
  GeoBounds all = tile_bounds(map.front().area);
  for (const SceneTile& tile : map) {
    const GeoBounds b = tile_bounds(tile.area);
    all = {std::min(all.west, b.west), std::min(all.south, b.south), std::max(all.east, b.east),
           std::max(all.north, b.north)};
  }
  return all;
}

class Canvas {
 public:
  explicit Canvas(const GeoBounds& bounds)
      : bounds_(bounds), scale_(kPicture / std::max(bounds.width(), bounds.height())) {
    out_ << "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" << width() << "\" height=\"" << height()
         << "\" font-family=\"sans-serif\" font-size=\"13\">\n<rect width=\"100%\" height=\"100%\" "
            "fill=\"white\"/>\n";
  }

  void tile(const GeoBounds& b, std::string_view fill) {
    out_ << "<rect x=\"" << x(b.west) << "\" y=\"" << y(b.north) << "\" width=\"" << b.width() * scale_
         << "\" height=\"" << b.height() * scale_ << "\" fill=\"" << fill << "\" stroke=\"#222\"/>\n";
  }

  void title(std::string_view text) {
    out_ << "<text x=\"" << kMargin << "\" y=\"" << kMargin - 8 << "\">" << text << "</text>\n";
  }

  std::string finish() {
    out_ << "</svg>\n";
    return out_.str();
  }

 private:
  double width() const { return bounds_.width() * scale_ + 2 * kMargin; }
  double height() const { return bounds_.height() * scale_ + 2 * kMargin; }
  double x(double lon) const { return kMargin + (lon - bounds_.west) * scale_; }
  double y(double lat) const { return kMargin + (bounds_.north - lat) * scale_; }

  GeoBounds bounds_;
  double scale_;
  std::ostringstream out_;
};

/// Finer is darker: the steps of a light-to-dark blue, as many as there are levels.
std::string shade(int level, int coarsest, int finest) {
  const double t = finest == coarsest ? 1 : static_cast<double>(level - coarsest) / (finest - coarsest);
  const auto mix = [t](double light, double dark) {
    return std::to_string(static_cast<int>(light + (dark - light) * t + 0.5));
  };
  return "rgb(" + mix(236, 70) + "," + mix(242, 130) + "," + mix(250, 200) + ")";
}

}  // namespace

std::string draw_map(const SceneMap& map, const TileId& eye, std::string_view title) {
  assert(!map.empty());
  const int coarsest = map.front().area.level;
  const int finest = map.back().area.level;
  Canvas canvas(bounds_of(map));
  canvas.title(title);
  for (const SceneTile& tile : map) {
    canvas.tile(tile_bounds(tile.area),
                tile.area == eye ? "black" : shade(tile.area.level, coarsest, finest));
  }
  return canvas.finish();
}

}  // namespace cairn
