#include "runtime/surface/surface_tile.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "format/rqt_steps.h"
#include "runtime/surface/area_sphere.h"

namespace cairn {
namespace {

/// The largest deviation, in quanta, of samples at odd multiples of `step` from the triangles through the
/// even ones.
double deviation_of_step(const HeightTile& tile, int step) {
  std::int64_t twice_worst = 0;
  const auto compare = [&](int c, int r, int dc, int dr) {
    const std::int64_t ends = static_cast<std::int64_t>(tile.at(c - dc, r - dr)) + tile.at(c + dc, r + dr);
    twice_worst = std::max(twice_worst, std::abs(ends - 2 * static_cast<std::int64_t>(tile.at(c, r))));
  };
  const int cells = tile.size - 1;
  for (int r = 0; r <= cells; r += step) {
    const bool odd_row = (r / step) % 2 == 1;
    for (int c = odd_row ? 0 : step; c <= cells; c += odd_row ? step : 2 * step) {
      const bool odd_column = (c / step) % 2 == 1;
      const bool is_centre = odd_column && odd_row;
      if (!is_centre || diagonal_rises(true, tile.size, c - step, r - step, 2 * step)) {
        compare(c, r, odd_column ? step : 0, odd_row ? step : 0);
      }
      // Which way the diagonal of the tile itself runs depends on the tile's place.
      if (is_centre &&
          (2 * step == cells || !diagonal_rises(true, tile.size, c - step, r - step, 2 * step))) {
        compare(c, r, step, -step);
      }
    }
  }
  return static_cast<double>(twice_worst) / 2;
}

}  // namespace

int cells_log2_of(int tile_size) {
  assert(std::has_single_bit(static_cast<unsigned>(tile_size - 1)));
  return std::countr_zero(static_cast<unsigned>(tile_size - 1));
}

DecimationErrors decimation_errors(const HeightTile& tile, double quantum_m) {
  DecimationErrors errors{};
  double sum = 0;
  for (int k = 1; k <= kMaxCellsLog2; ++k) {
    if (1 << k < tile.size) sum += deviation_of_step(tile, 1 << (k - 1)) * quantum_m;
    errors[static_cast<std::size_t>(k)] = static_cast<float>(sum);
  }
  return errors;
}

SquareSpheres::SquareSpheres(const HeightTile& tile, const TileId& id, double quantum_m,
                             const Ellipsoid& ellipsoid)
    : id_(id), levels_(cells_log2_of(tile.size) - kLeastCellsLog2) {
  struct Range {
    std::int32_t low = std::numeric_limits<std::int32_t>::max();
    std::int32_t high = std::numeric_limits<std::int32_t>::min();
    void add(const Range& other) {
      low = std::min(low, other.low);
      high = std::max(high, other.high);
    }
  };
  const int across = 1 << levels_, cells = 1 << kLeastCellsLog2;
  std::vector<Range> ranges(static_cast<std::size_t>(across) * static_cast<std::size_t>(across));
  for (int y = 0; y < across; ++y) {
    for (int x = 0; x < across; ++x) {
      Range& range = ranges[static_cast<std::size_t>(y * across + x)];
      for (int r = y * cells; r <= (y + 1) * cells; ++r) {
        for (int c = x * cells; c <= (x + 1) * cells; ++c) range.add({tile.at(c, r), tile.at(c, r)});
      }
    }
  }
  std::size_t count = 0;
  for (int k = 0; k <= levels_; ++k) {
    first_[static_cast<std::size_t>(k)] = count;
    count += std::size_t{1} << (2 * k);
  }
  spheres_.resize(count);
  for (int k = levels_;; --k) {
    const int side = 1 << k;
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        const auto i = static_cast<std::size_t>(y * side + x);
        spheres_[first_[static_cast<std::size_t>(k)] + i] =
            sphere_around({id.level + k, (id.x << k) + x, (id.y << k) + y}, ranges[i].low * quantum_m,
                          ranges[i].high * quantum_m, ellipsoid);
      }
    }
    if (k == 0) return;
    std::vector<Range> larger(ranges.size() / 4);
    for (int y = 0; y < side; ++y) {
      for (int x = 0; x < side; ++x) {
        larger[static_cast<std::size_t>(y / 2 * (side / 2) + x / 2)].add(
            ranges[static_cast<std::size_t>(y * side + x)]);
      }
    }
    ranges = std::move(larger);
  }
}

const SquareSphere& SquareSpheres::around(const TileId& area) const {
  const int deeper = area.level - id_.level;
  const std::int32_t x = area.x - (id_.x << deeper), y = area.y - (id_.y << deeper);
  return spheres_[first_[static_cast<std::size_t>(deeper)] + (static_cast<std::size_t>(y) << deeper) +
                  static_cast<std::size_t>(x)];
}

SurfaceTile prepare_surface_tile(const TileId& id, std::shared_ptr<const HeightTile> heights,
                                 double quantum_m, bool between_samples, const Ellipsoid& ellipsoid) {
  const HeightTile& tile = *heights;
  return {id,
          std::move(heights),
          quantum_m,
          range_of(tile),
          decimation_errors(tile, quantum_m),
          VertexSteps(tile, id, quantum_m, between_samples),
          SquareSpheres(tile, id, quantum_m, ellipsoid),
          column_table(id.level, id.x, tile.size),
          row_table(id.level, id.y, tile.size, ellipsoid)};
}

std::uint64_t SurfaceTile::bytes() const {
  return steps.bytes() + spheres.bytes() + columns.size() * sizeof(ColumnEntry) +
         rows.size() * sizeof(RowEntry);
}

namespace {

enum class Voids { are_nan, are_filled };

/// Of the tile with only every 2^dropped-th row and column kept.
float thinned_height_at(const SurfaceTile& tile, const LatticePoint& point, int dropped, Voids voids) {
  const HeightTile& heights = *tile.heights;
  const int cells_log2 = cells_log2_of(heights.size);
  const std::int64_t cell = lattice_width(tile.id.level + cells_log2 - dropped);
  const LatticePoint origin = south_west_of(tile.id);
  const std::int64_t dx = point.x - origin.x, dy = point.y - origin.y;
  assert(dx >= 0 && dy >= 0 && dx <= lattice_width(tile.id.level) && dy <= lattice_width(tile.id.level));
  const auto c = static_cast<int>(dx / cell), r = static_cast<int>(dy / cell);
  const double u = static_cast<double>(dx % cell) / static_cast<double>(cell);
  const double v = static_cast<double>(dy % cell) / static_cast<double>(cell);
  const auto metres = [&](int column, int row) {
    column <<= dropped;
    row <<= dropped;
    if (voids == Voids::are_nan && heights.is_void(column, row))
      return std::numeric_limits<double>::quiet_NaN();
    return static_cast<double>(static_cast<float>(heights.at(column, row)) *
                               static_cast<float>(tile.quantum_m));
  };
  // A sample without weight is not read: it may be void, or beyond the tile.
  if (u == 0 && v == 0) return static_cast<float>(metres(c, r));
  const bool one_cell = cells_log2 == dropped;
  if (one_cell ? root_rises(tile.id) : ((c ^ r) & 1) == 0) {
    const double high = std::max(u, v), low = std::min(u, v);
    double height = metres(c, r);
    const double other = low == high ? height : u > v ? metres(c + 1, r) : metres(c, r + 1);
    height += (other - height) * high;
    if (low > 0) height += (metres(c + 1, r + 1) - other) * low;
    return static_cast<float>(height);
  }
  if (u + v <= 1) {
    double height = metres(c, r);
    const double from = height;
    if (u > 0) height += (metres(c + 1, r) - from) * u;
    if (v > 0) height += (metres(c, r + 1) - from) * v;
    return static_cast<float>(height);
  }
  double height = metres(c + 1, r + 1);
  const double from = height;
  if (u < 1) height += (metres(c, r + 1) - from) * (1 - u);
  if (v < 1) height += (metres(c + 1, r) - from) * (1 - v);
  return static_cast<float>(height);
}

}  // namespace

float height_at(const SurfaceTile& tile, const LatticePoint& point) {
  return thinned_height_at(tile, point, 0, Voids::are_nan);
}

ShownSurface ShownSurface::of(const SurfaceTile* tile, double detail) {
  if (!tile) return {};
  // With less than kMinLevel has, the end of the world would lie between samples.
  const int level = tile->id.level, least = std::max(level - cells_log2_of(tile->heights->size), kMinLevel);
  return {tile, std::clamp<double>(detail, least, level)};
}

int ShownSurface::finer_level() const {
  return static_cast<int>(std::ceil(detail));
}

float ShownSurface::coarser_share() const {
  return static_cast<float>(finer_level() - detail);
}

ShownHeight shown_height_at(const ShownSurface& surface, const LatticePoint& point) {
  const SurfaceTile& tile = *surface.tile;
  const float finest = thinned_height_at(tile, point, 0, Voids::are_nan);
  if (std::isnan(finest)) return {thinned_height_at(tile, point, 0, Voids::are_filled), 0, true};
  const auto known = [&](int rows_dropped) {
    float height = finest;
    do {
      height = rows_dropped == 0 ? finest : thinned_height_at(tile, point, rows_dropped, Voids::are_nan);
      --rows_dropped;
    } while (std::isnan(height));
    return height;
  };
  const int dropped = tile.id.level - surface.finer_level();
  const float finer = known(dropped);
  return {finer, surface.coarser_share() > 0 ? known(dropped + 1) - finer : 0, false};
}

float height_at(const ShownSurface& surface, const LatticePoint& point) {
  const ShownHeight height = shown_height_at(surface, point);
  return height.is_void ? std::numeric_limits<float>::quiet_NaN() : height.at(surface.coarser_share());
}

}  // namespace cairn
