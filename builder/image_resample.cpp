#include "builder/image_resample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "builder/pixel_block.h"
#include "builder/pixel_taps.h"
#include "builder/srgb.h"

namespace cairn {
namespace {

using std::int64_t;
using Position = Georeference::ColumnRow;

constexpr float kOne = 65535;

WideTexel load(const std::uint8_t* pixel, const std::array<float, 256>& linear) {
  const WideTexel colour{linear[pixel[0]], linear[pixel[1]], linear[pixel[2]], kOne};
  return pixel[3] == 255 ? colour : colour * (static_cast<float>(pixel[3]) / 255.0F);
}

// A cubic overshoots: alpha stays in its range, and no colour is brighter than its alpha.
WideTexel in_range(WideTexel texel) {
  const float alpha = std::clamp(texel[3], 0.0F, kOne);
  for (int i = 0; i < 3; ++i) texel[i] = std::clamp(texel[i], 0.0F, alpha);
  texel[3] = alpha;
  return texel;
}

// Pixels from a position to the image's rim, below 0 outside.
double rim_distance(const RasterInfo& info, Position p) {
  const double columns = static_cast<double>(info.columns), rows = static_cast<double>(info.rows);
  const double across = goes_around(info) ? HUGE_VAL : std::min(p.column + 0.5, columns - 0.5 - p.column);
  return std::min({across, p.row + 0.5, rows - 0.5 - p.row});
}

// Texels first…last of those positions along one axis whose centres lie in the image.
struct Inside {
  int first = 0;
  int count = 0;
};

Inside inside_of(const std::vector<double>& positions, int64_t pixels, bool unbounded) {
  const auto in = [&](double p) {
    return unbounded || (p >= -0.5 && p <= static_cast<double>(pixels) - 0.5);
  };
  const auto first = std::find_if(positions.begin(), positions.end(), in);
  const auto last = std::find_if(positions.rbegin(), positions.rend(), in).base();
  if (first >= last) return {};
  return {static_cast<int>(first - positions.begin()), static_cast<int>(last - first)};
}

void keep(std::vector<double>& positions, Inside inside) {
  positions.erase(positions.begin() + inside.first + inside.count, positions.end());
  positions.erase(positions.begin(), positions.begin() + inside.first);
}

PostWindow pixels_for(const PixelTaps& columns, const PixelTaps& rows) {
  const auto [west, east] = std::minmax_element(columns.first.begin(), columns.first.end());
  const auto [north, south] = std::minmax_element(rows.first.begin(), rows.first.end());
  return {*west, *north, *east - *west + columns.count, *south - *north + rows.count};
}

// Rows of pixels, filtered along the row, kept for as long as texels need them.
class FilteredRows {
 public:
  FilteredRows(const PixelBlock& block, const PixelTaps& columns, int keep)
      : block_(block), columns_(columns), pixels_(static_cast<std::size_t>(block.columns)) {
    rows_.resize(static_cast<std::size_t>(keep));
  }

  const WideTexel* row(int64_t pixel_row) {
    Row& kept = rows_[static_cast<std::size_t>(pixel_row - block_.row) % rows_.size()];
    if (kept.texels.empty() || kept.pixel_row != pixel_row) filter(pixel_row, kept);
    return kept.texels.data();
  }

 private:
  struct Row {
    int64_t pixel_row = 0;
    std::vector<WideTexel> texels;
  };

  void filter(int64_t pixel_row, Row& out) {
    const std::uint8_t* pixel = block_.at(block_.column, pixel_row);
    for (WideTexel& p : pixels_) p = load(std::exchange(pixel, pixel + 4), linear_);
    out.pixel_row = pixel_row;
    out.texels.resize(columns_.first.size());
    const float* weight = columns_.weights.data();
    for (std::size_t c = 0; c < out.texels.size(); ++c) {
      const WideTexel* from = &pixels_[static_cast<std::size_t>(columns_.first[c] - block_.column)];
      WideTexel sum{};
      for (int i = 0; i < columns_.count; ++i) sum += from[i] * *weight++;
      out.texels[c] = sum;
    }
  }

  const PixelBlock& block_;
  const PixelTaps& columns_;
  const std::array<float, 256>& linear_ = linear_of_srgb();
  std::vector<WideTexel> pixels_;
  std::vector<Row> rows_;
};

// Where columns depend on the longitude alone and rows on the latitude alone: one axis after the other.
Result<ResampledImage> resample_separable(const RasterSource& source, const TexelWindow& window,
                                          double turn) {
  const RasterInfo& info = source.info();
  std::vector<double> xs, ys;
  for (int c = 0; c < window.columns; ++c)
    xs.push_back(info.georeference.post_at({window.lon_of(c) + turn, 0}).column);
  for (int r = 0; r < window.rows; ++r)
    ys.push_back(info.georeference.post_at({0, std::clamp(window.lat_of(r), -90.0, 90.0)}).row);
  const Inside across = inside_of(xs, info.columns, goes_around(info));
  const Inside down = inside_of(ys, info.rows, false);
  ResampledImage image{across.first, down.first, across.count, down.count, {}, {}};
  if (across.count == 0 || down.count == 0) return image;
  keep(xs, across);
  keep(ys, down);

  const PixelTaps columns = taps_along(xs);
  const PixelTaps rows = taps_along(ys);
  const auto block = read_block(source, pixels_for(columns, rows));
  if (!block) return block.error();
  FilteredRows filtered(*block, columns, rows.count);
  const auto width = static_cast<std::size_t>(across.count);
  image.texels.assign(width * ys.size(), WideTexel{});
  const float* weight = rows.weights.data();
  for (std::size_t r = 0; r < ys.size(); ++r) {
    WideTexel* out = &image.texels[r * width];
    for (int i = 0; i < rows.count; ++i, ++weight) {
      const WideTexel* from = filtered.row(rows.first[r] + i);
      for (std::size_t c = 0; c < width; ++c) out[c] += from[c] * *weight;
    }
    for (std::size_t c = 0; c < width; ++c) {
      out[c] = in_range(out[c]);
      image.rims.push_back(static_cast<float>(rim_distance(info, {xs[c], ys[r]})));
    }
  }
  return image;
}

// The positions of all texels: every 8th by the projection, which is smooth, the others between them. The
// 8th ones are the world grid's, so that every window has the same.
class Positions {
 public:
  Positions(const Georeference& georeference, const TexelWindow& window, double turn)
      : column0_(floor_step(window.column)), row0_(floor_step(window.row)), window_(window) {
    TexelWindow grid = window;
    grid.column = column0_;
    grid.row = row0_;
    across_ = static_cast<int>((window.column + window.columns - column0_) / kStep) + 2;
    const int down = static_cast<int>((window.row + window.rows - row0_) / kStep) + 2;
    for (int r = 0; r < down; ++r) {
      for (int c = 0; c < across_; ++c)
        nodes_.push_back(georeference.post_at({grid.lon_of(c * kStep) + turn, grid.lat_of(r * kStep)}));
    }
  }

  Position of(int c, int r) const {
    const int64_t x = window_.column + c - column0_, y = window_.row + r - row0_;
    const auto at = static_cast<std::size_t>(y / kStep * across_ + x / kStep);
    const double u = static_cast<double>(x % kStep) / kStep, v = static_cast<double>(y % kStep) / kStep;
    const auto between = [&](double Position::*axis) {
      const auto next = at + static_cast<std::size_t>(across_);
      const double north = nodes_[at].*axis + u * (nodes_[at + 1].*axis - nodes_[at].*axis);
      const double south = nodes_[next].*axis + u * (nodes_[next + 1].*axis - nodes_[next].*axis);
      return north + v * (south - north);
    };
    return {between(&Position::column), between(&Position::row)};
  }

 private:
  static constexpr int kStep = 8;
  static int64_t floor_step(int64_t i) { return (i >= 0 ? i : i - kStep + 1) / kStep * kStep; }

  int64_t column0_;
  int64_t row0_;
  TexelWindow window_;
  int across_ = 0;
  std::vector<Position> nodes_;
};

// How many pixels a texel is wide along each axis of the raster.
Position texel_size(const Georeference& g, const TexelWindow& window, double turn) {
  const double c = window.columns / 2.0, r = window.rows / 2.0;
  const auto at = [&](double dc, double dr) {
    return g.post_at({window.lon_of(c + dc) + turn, window.lat_of(r + dr)});
  };
  const Position a = at(0, 0), east = at(1, 0), south = at(0, 1);
  return {std::max({1.0, std::abs(east.column - a.column), std::abs(south.column - a.column)}),
          std::max({1.0, std::abs(east.row - a.row), std::abs(south.row - a.row)})};
}

// Sizes in steps, so that neighbouring windows have the same but where a step lies between them.
Position in_steps(Position size) {
  const auto step = [](double s) { return s < 1.01 ? 1.0 : std::ceil(s * 16) / 16; };
  return {step(size.column), step(size.row)};
}

struct TapRun {
  int64_t first = 0;
  std::array<float, 16> weights;
};

Result<ResampledImage> resample_projected(const RasterSource& source, const TexelWindow& window,
                                          double turn) {
  const RasterInfo& info = source.info();
  const Positions positions(info.georeference, window, turn);
  const Position size = in_steps(texel_size(info.georeference, window, turn));
  const double widest = static_cast<double>(std::tuple_size_v<decltype(TapRun::weights)>) / 4;
  const double sx = std::min(size.column, widest), sy = std::min(size.row, widest);
  const int across = taps_for(sx), down = taps_for(sy);

  PostWindow wanted{info.columns, info.rows, 0, 0};
  int64_t east = -1, south = -1;
  for (int r = 0; r < window.rows; ++r) {
    for (int c = 0; c < window.columns; ++c) {
      const Position p = positions.of(c, r);
      if (rim_distance(info, p) < 0) continue;
      wanted.column = std::min(wanted.column, first_tap(p.column, sx));
      wanted.row = std::min(wanted.row, first_tap(p.row, sy));
      east = std::max(east, first_tap(p.column, sx) + across);
      south = std::max(south, first_tap(p.row, sy) + down);
    }
  }
  if (east < 0) return ResampledImage{};
  wanted.columns = east - wanted.column;
  wanted.rows = south - wanted.row;
  const auto block = read_block(source, wanted);
  if (!block) return block.error();
  std::vector<WideTexel> pixels(block->rgba.size() / 4);
  for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = load(&block->rgba[4 * i], linear_of_srgb());

  ResampledImage image{0, 0, window.columns, window.rows, {}, {}};
  for (int r = 0; r < window.rows; ++r) {
    for (int c = 0; c < window.columns; ++c) {
      const Position p = positions.of(c, r);
      const double rim = rim_distance(info, p);
      image.rims.push_back(static_cast<float>(rim));
      image.texels.push_back(WideTexel{});
      if (rim < 0) continue;
      TapRun x{first_tap(p.column, sx), {}}, y{first_tap(p.row, sy), {}};
      tap_weights(p.column, sx, across, x.weights.data());
      tap_weights(p.row, sy, down, y.weights.data());
      const WideTexel* row = &pixels[static_cast<std::size_t>((y.first - wanted.row) * wanted.columns +
                                                              x.first - wanted.column)];
      for (int j = 0; j < down; ++j, row += wanted.columns) {
        WideTexel sum{};
        for (int i = 0; i < across; ++i) sum += row[i] * x.weights[static_cast<std::size_t>(i)];
        image.texels.back() += sum * y.weights[static_cast<std::size_t>(j)];
      }
      image.texels.back() = in_range(image.texels.back());
    }
  }
  return image;
}

}  // namespace

Result<ResampledImage> resample_image(const RasterSource& source, const TexelWindow& window, double turn) {
  if (source.info().georeference.crs == Georeference::Crs::utm)
    return resample_projected(source, window, turn);
  return resample_separable(source, window, turn);
}

}  // namespace cairn
