#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "builder/imagery/image_resample.h"
#include "builder/imagery/linear_pixels.h"
#include "builder/imagery/pixel_block.h"
#include "builder/imagery/pixel_taps.h"
#include "builder/imagery/texel_loops.h"
#include "builder/resample/projection_mesh.h"

namespace cairn {
namespace {

using std::int64_t;

constexpr int kMostTaps = 16;

// Images that touch have places of their own, each within this of the truth, and no texel may fall between
// them.
constexpr double kSlack = 0.01;      // of a pixel, beyond the image's rim
constexpr double kTolerance = 1e-3;  // of a pixel

// How many pixels a texel is wide along each axis of the raster, at least 1, in steps, so that neighbouring
// windows have the same but where a step lies between them.
PlanePoint texel_size(const Georeference& g, const TexelWindow& window, double turn) {
  const double c = window.columns / 2.0, r = window.rows / 2.0;
  const auto at = [&](double dc, double dr) {
    return g.post_at({window.lon_of(c + dc) + turn, std::clamp(window.lat_of(r + dr), -90.0, 90.0)});
  };
  const auto step = [](double a, double b) {
    const double size = std::max(std::abs(a), std::abs(b));
    return size < 1.01 || !std::isfinite(size) ? 1.0 : std::min(std::ceil(size * 16) / 16, kMostTaps / 4.0);
  };
  const auto a = at(0, 0), east = at(1, 0), south = at(0, 1);
  return {step(east.column - a.column, south.column - a.column), step(east.row - a.row, south.row - a.row)};
}

// The positions of a window's texels in the raster; not finite where it has none.
ProjectionMesh positions_of(const Georeference& georeference, const TexelWindow& window, double turn) {
  const IndexWindow texels = {{window.column, window.column + window.columns - 1},
                              {window.row, window.row + window.rows - 1}};
  return ProjectionMesh(texels, projection_mesh_step(window.texels_per_degree), kTolerance,
                        [&georeference, window, turn](int64_t x, int64_t y) {
                          const double c = static_cast<double>(x - window.column),
                                       r = static_cast<double>(y - window.row);
                          const LonLat place{window.lon_of(c) + turn, window.lat_of(r)};
                          if (std::abs(place.lat) > 90) return PlanePoint{NAN, NAN};
                          const auto post = georeference.post_at(place);
                          return PlanePoint{post.column, post.row};
                        });
}

// Where texels lie in the raster, as far as they lie in the image.
struct Reach {
  PlanePoint low{HUGE_VAL, HUGE_VAL};
  PlanePoint high{-HUGE_VAL, -HUGE_VAL};

  void add(const PlanePoint& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  bool holds(const PlanePoint& p) const {
    return p.x >= low.x && p.y >= low.y && p.x <= high.x && p.y <= high.y;
  }
  bool is_empty() const { return !(low.x <= high.x && low.y <= high.y); }
};

// The image's own area, to the outer edges of its pixels.
Reach area_of(const RasterInfo& info) {
  const double edge = 0.5 + kSlack;
  return {{-edge, -edge},
          {static_cast<double>(info.columns - 1) + edge, static_cast<double>(info.rows - 1) + edge}};
}

// The part of the image's area in which there are texels.
Reach reach_of(const RasterInfo& info, const TexelWindow& window, const ProjectionMesh& mesh) {
  const Reach area = area_of(info);
  Reach reach;
  std::vector<PlanePoint> positions(static_cast<std::size_t>(window.columns));
  for (int r = 0; r < window.rows; ++r) {
    mesh.row(window.row + r, positions);
    for (const PlanePoint& p : positions)
      if (area.holds(p)) reach.add(p);
  }
  return reach;
}

// The pixels that texels within reach are made of.
PostWindow pixels_for(const Reach& reach, PlanePoint size) {
  const int64_t west = first_tap(reach.low.x, size.x), north = first_tap(reach.low.y, size.y);
  return {west, north, first_tap(reach.high.x, size.x) + taps_for(size.x) - west,
          first_tap(reach.high.y, size.y) + taps_for(size.y) - north};
}

// Texels larger than pixels.
void average_row(const FloatPixels& image, std::span<const PlanePoint> positions, PlanePoint size,
                 LinearTexel* out) {
  const int across = taps_for(size.x), down = taps_for(size.y);
  std::array<float, kMostTaps> x_weights, y_weights;
  for (const PlanePoint& p : positions) {
    tap_weights(p.x, size.x, across, x_weights.data());
    tap_weights(p.y, size.y, down, y_weights.data());
    const FloatTexel* row = image.pixels + (first_tap(p.y, size.y) - image.row) * image.columns +
                            (first_tap(p.x, size.x) - image.column);
    FloatTexel sum{};
    for (int j = 0; j < down; ++j, row += image.columns) {
      FloatTexel line{};
      for (int i = 0; i < across; ++i) line += row[i] * x_weights[static_cast<std::size_t>(i)];
      sum += line * y_weights[static_cast<std::size_t>(j)];
    }
    *out++ = texel_loops().quantise(sum);
  }
}

// Texels within reach.
void resample_run(const FloatPixels& image, std::span<const PlanePoint> positions, PlanePoint size,
                  LinearTexel* out) {
  if (size.x == 1 && size.y == 1) return texel_loops().interpolate(image, positions, out);
  average_row(image, positions, size, out);
}

// A row of texels, empty where they lie out of reach. Returns whether none does.
bool resample_row(const FloatPixels& image, const Reach& reach, std::span<const PlanePoint> positions,
                  PlanePoint size, LinearTexel* out) {
  if (texel_loops().all_within(positions, reach.low, reach.high)) {
    resample_run(image, positions, size, out);
    return true;
  }
  std::fill_n(out, positions.size(), LinearTexel{});
  const auto inside = [&](const PlanePoint& p) { return reach.holds(p); };
  for (auto from = positions.begin(); from != positions.end();) {
    from = std::find_if(from, positions.end(), inside);
    const auto to = std::find_if_not(from, positions.end(), inside);
    resample_run(image, {from, to}, size, out + (from - positions.begin()));
    from = to;
  }
  return false;
}

}  // namespace

Result<ResampledImage> resample_warped(const RasterSource& source, const TexelWindow& window, double turn,
                                       bool with_rims) {
  const RasterInfo& info = source.info();
  const ProjectionMesh mesh = positions_of(info.georeference, window, turn);
  const Reach reach = reach_of(info, window, mesh);
  if (reach.is_empty()) return ResampledImage{};
  const PlanePoint size = texel_size(info.georeference, window, turn);
  const auto block = read_block(source, pixels_for(reach, size));
  if (!block) return block.error();
  UninitializedVector<FloatTexel> pixels(block->rgba.size() / 4);
  to_linear_light(block->rgba.data(), pixels);
  const FloatPixels wide{pixels.data(), block->column, block->row, block->columns};

  std::vector<PlanePoint> positions(static_cast<std::size_t>(window.columns));
  ResampledImage image{0, 0, LinearImage::unset(window.columns, window.rows), is_opaque(*block), {}};
  for (int r = 0; r < window.rows; ++r) {
    mesh.row(window.row + r, positions);
    if (!resample_row(wide, reach, positions, size, image.texels.row(r))) image.is_opaque = false;
    if (!with_rims) continue;
    for (const PlanePoint& p : positions) image.rims.push_back(static_cast<float>(rim_distance(info, p)));
  }
  return image;
}

}  // namespace cairn
