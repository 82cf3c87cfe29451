#include "builder/warped_image.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "builder/coarse_mesh.h"
#include "builder/pixel_block.h"
#include "builder/pixel_taps.h"
#include "builder/texel_rows.h"
#include "builder/wide_pixels.h"

namespace cairn {
namespace {

using std::int64_t;

constexpr int kMostTaps = 16;

// How many pixels a texel is wide along each axis of the raster, at least 1, in steps, so that neighbouring
// windows have the same but where a step lies between them.
PlanePoint texel_size(const Georeference& g, const TexelWindow& window, double turn) {
  const double c = window.columns / 2.0, r = window.rows / 2.0;
  const auto at = [&](double dc, double dr) {
    return g.post_at({window.lon_of(c + dc) + turn, window.lat_of(r + dr)});
  };
  const auto step = [](double a, double b) {
    const double size = std::max(std::abs(a), std::abs(b));
    return size < 1.01 ? 1.0 : std::min(std::ceil(size * 16) / 16, kMostTaps / 4.0);
  };
  const auto a = at(0, 0), east = at(1, 0), south = at(0, 1);
  return {step(east.column - a.column, south.column - a.column), step(east.row - a.row, south.row - a.row)};
}

// The positions of a window's texels in the raster, row by row.
std::vector<PlanePoint> positions_of(const Georeference& georeference, const TexelWindow& window,
                                     double turn) {
  const IndexWindow texels = {{window.column, window.column + window.columns - 1},
                              {window.row, window.row + window.rows - 1}};
  const auto position = [&](int64_t x, int64_t y) {
    const double c = static_cast<double>(x - window.column), r = static_cast<double>(y - window.row);
    const auto post = georeference.post_at({window.lon_of(c) + turn, window.lat_of(r)});
    return PlanePoint{post.column, post.row};
  };
  const CoarseMesh mesh(texels, projection_mesh_step(window.texels_per_degree), position);
  const auto columns = static_cast<std::size_t>(window.columns);
  std::vector<PlanePoint> positions(columns * static_cast<std::size_t>(window.rows));
  for (int r = 0; r < window.rows; ++r)
    mesh.row(window.row + r, std::span(positions).subspan(static_cast<std::size_t>(r) * columns, columns));
  return positions;
}

bool is_inside(const RasterInfo& info, const PlanePoint& p) {
  return p.x >= -0.5 && p.y >= -0.5 && p.x <= static_cast<double>(info.columns) - 0.5 &&
         p.y <= static_cast<double>(info.rows) - 0.5;
}

// The pixels that texels at those positions are made of; nullopt where none lies in the image.
std::optional<PostWindow> pixels_for(const RasterInfo& info, std::span<const PlanePoint> positions,
                                     PlanePoint size) {
  PlanePoint low{HUGE_VAL, HUGE_VAL}, high{-HUGE_VAL, -HUGE_VAL};
  for (const PlanePoint& p : positions) {
    if (!is_inside(info, p)) continue;
    low = {std::min(low.x, p.x), std::min(low.y, p.y)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y)};
  }
  if (low.x > high.x) return std::nullopt;
  const int64_t west = first_tap(low.x, size.x), north = first_tap(low.y, size.y);
  return PostWindow{west, north, first_tap(high.x, size.x) + taps_for(size.x) - west,
                    first_tap(high.y, size.y) + taps_for(size.y) - north};
}

// Texels larger than pixels.
void average_row(const WidePixels& image, std::span<const PlanePoint> positions, PlanePoint size,
                 LinearTexel* out) {
  const int across = taps_for(size.x), down = taps_for(size.y);
  std::array<float, kMostTaps> x_weights, y_weights;
  for (const PlanePoint& p : positions) {
    tap_weights(p.x, size.x, across, x_weights.data());
    tap_weights(p.y, size.y, down, y_weights.data());
    const WideTexel* row = image.pixels + (first_tap(p.y, size.y) - image.row) * image.columns +
                           (first_tap(p.x, size.x) - image.column);
    WideTexel sum{};
    for (int j = 0; j < down; ++j, row += image.columns) {
      WideTexel line{};
      for (int i = 0; i < across; ++i) line += row[i] * x_weights[static_cast<std::size_t>(i)];
      sum += line * y_weights[static_cast<std::size_t>(j)];
    }
    *out++ = to_linear_texel(sum);
  }
}

}  // namespace

Result<ResampledImage> resample_warped(const RasterSource& source, const TexelWindow& window, double turn,
                                       bool with_rims) {
  const RasterInfo& info = source.info();
  const PlanePoint size = texel_size(info.georeference, window, turn);
  const std::vector<PlanePoint> positions = positions_of(info.georeference, window, turn);
  const auto wanted = pixels_for(info, positions, size);
  if (!wanted) return ResampledImage{};
  const auto block = read_block(source, *wanted);
  if (!block) return block.error();
  std::vector<WideTexel> pixels(block->rgba.size() / 4);
  to_linear_light(block->rgba.data(), pixels);
  const WidePixels wide{pixels.data(), block->column, block->row, block->columns};

  ResampledImage image{0, 0, LinearImage(window.columns, window.rows), {}};
  const auto inside = [&](const PlanePoint& p) { return is_inside(info, p); };
  for (auto from = positions.begin(); from != positions.end();) {
    from = std::find_if(from, positions.end(), inside);
    const auto to = std::find_if_not(from, positions.end(), inside);
    LinearTexel* out = image.texels.texels.data() + (from - positions.begin());
    if (size.x == 1 && size.y == 1) {
      texel_rows().interpolate(wide, {from, to}, out);
    } else {
      average_row(wide, {from, to}, size, out);
    }
    from = to;
  }
  if (!with_rims) return image;
  for (const PlanePoint& p : positions) image.rims.push_back(static_cast<float>(rim_distance(info, p)));
  return image;
}

}  // namespace cairn
