#include "builder/objects/billboard.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

namespace cairn {
namespace {

constexpr int kColumns = 4;
constexpr int kRows = kBillboardViews / kColumns;
constexpr int kSize = 256;
constexpr int kFiner = 2;  // it is drawn so many times as large, and then reduced
constexpr int kCellWidth = kFiner * kSize / kColumns;
constexpr int kCellHeight = kFiner * kSize / kRows;

struct ScreenVertex {
  double x = 0, y = 0;  // texels of the cell
  double depth = 0;     // larger is nearer
  std::array<double, 2> texture{};
};

/// One view, with the nearest depth of each texel.
class ViewPainter {
 public:
  ViewPainter(const ObjectModel& model, const Picture& texture, int view, Picture& out)
      : model_(model),
        texture_(texture),
        left_(view % kColumns * kCellWidth),
        above_(view / kColumns * kCellHeight),
        sine_(std::sin(view * 2 * std::numbers::pi / kBillboardViews)),
        cosine_(std::cos(view * 2 * std::numbers::pi / kBillboardViews)),
        out_(out),
        nearest_(static_cast<std::size_t>(kCellWidth) * kCellHeight,
                 -std::numeric_limits<double>::infinity()) {}

  void draw_all() {
    const ModelLevel& finest = model_.levels[0];
    for (std::size_t i = finest.first; i < finest.first + finest.count; i += 3) {
      draw(
          {on_screen(model_.indices[i]), on_screen(model_.indices[i + 1]), on_screen(model_.indices[i + 2])});
    }
  }

 private:
  // The eye lies at (sine, cosine) east and north; right of it is (-cosine, sine).
  ScreenVertex on_screen(std::uint16_t index) const {
    const ModelVertex& v = model_.vertices[index];
    const double east = static_cast<double>(v.position_m[0]), north = static_cast<double>(v.position_m[1]);
    const double radius = std::max(static_cast<double>(model_.radius_m), 1e-6);
    const double height = std::max(static_cast<double>(model_.top_m - model_.bottom_m), 1e-6);
    const double across = (-cosine_ * east + sine_ * north) / radius;
    const double down = static_cast<double>(model_.top_m - v.position_m[2]) / height;
    return {(across + 1) / 2 * kCellWidth,
            down * kCellHeight,
            sine_ * east + cosine_ * north,
            {static_cast<double>(v.texture[0]), static_cast<double>(v.texture[1])}};
  }

  void draw(const std::array<ScreenVertex, 3>& t) {
    const double area = (t[1].x - t[0].x) * (t[2].y - t[0].y) - (t[2].x - t[0].x) * (t[1].y - t[0].y);
    if (std::abs(area) < 1e-9) return;
    const auto [left, right] = std::minmax({t[0].x, t[1].x, t[2].x});
    const auto [top, bottom] = std::minmax({t[0].y, t[1].y, t[2].y});
    const int last_x = std::min(kCellWidth - 1, static_cast<int>(right));
    const int last_y = std::min(kCellHeight - 1, static_cast<int>(bottom));
    for (int y = std::max(0, static_cast<int>(top)); y <= last_y; ++y) {
      for (int x = std::max(0, static_cast<int>(left)); x <= last_x; ++x) draw_texel(t, area, x, y);
    }
  }

  void draw_texel(const std::array<ScreenVertex, 3>& t, double area, int x, int y) {
    const double px = x + 0.5, py = y + 0.5;
    const auto share = [&](const ScreenVertex& a, const ScreenVertex& b) {
      return ((a.x - px) * (b.y - py) - (b.x - px) * (a.y - py)) / area;
    };
    const std::array<double, 3> w{share(t[1], t[2]), share(t[2], t[0]), share(t[0], t[1])};
    if (w[0] < 0 || w[1] < 0 || w[2] < 0) return;
    const auto mix = [&](auto of) { return w[0] * of(t[0]) + w[1] * of(t[1]) + w[2] * of(t[2]); };
    const double depth = mix([](const ScreenVertex& v) { return v.depth; });
    double& nearest = nearest_[static_cast<std::size_t>(y) * kCellWidth + static_cast<std::size_t>(x)];
    if (depth <= nearest) return;
    const auto texel = [&](std::size_t i, int size) {
      const double at = mix([i](const ScreenVertex& v) { return v.texture[i]; });
      return std::clamp(static_cast<int>(at * size), 0, size - 1);
    };
    const std::uint8_t* colour = texture_.at(texel(0, texture_.width), texel(1, texture_.height));
    if (colour[3] < 128) return;
    nearest = depth;
    std::copy_n(colour, 3, out_.at(left_ + x, above_ + y));
    out_.at(left_ + x, above_ + y)[3] = 255;
  }

  const ObjectModel& model_;
  const Picture& texture_;
  int left_, above_;
  double sine_, cosine_;
  Picture& out_;
  std::vector<double> nearest_;
};

}  // namespace

Picture draw_billboard(const ObjectModel& model, const Picture& texture) {
  Picture large = Picture::filled(kFiner * kSize, kFiner * kSize, {0, 0, 0, 0});
  for (int view = 0; view < kBillboardViews; ++view) ViewPainter(model, texture, view, large).draw_all();
  return resized(large, kSize, kSize);
}

}  // namespace cairn
