#include "runtime/surface/surface_tile.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace cairn::gl {
namespace {

/// A square of samples, both edges included.
struct Square {
  int column = 0;
  int row = 0;
  int cells = 0;
};

/// The largest deviation of samples at odd multiples of `step` from the triangles through the even ones.
double deviation_of_step(const HeightTile& tile, const Square& square, int step) {
  std::int64_t twice_worst = 0;
  const auto compare = [&](int c, int r, int dc, int dr) {
    const std::int64_t ends = static_cast<std::int64_t>(tile.at(c - dc, r - dr)) + tile.at(c + dc, r + dr);
    twice_worst = std::max(twice_worst, std::abs(ends - 2 * static_cast<std::int64_t>(tile.at(c, r))));
  };
  for (int j = 0; j <= square.cells; j += step) {
    const bool odd_row = (j / step) % 2 == 1;
    for (int i = odd_row ? 0 : step; i <= square.cells; i += odd_row ? step : 2 * step) {
      const bool odd_column = (i / step) % 2 == 1;
      compare(square.column + i, square.row + j, odd_column ? step : 0, odd_row ? step : 0);
    }
  }
  return static_cast<double>(twice_worst) / 2;
}

struct Range {
  std::int32_t low = std::numeric_limits<std::int32_t>::max();
  std::int32_t high = std::numeric_limits<std::int32_t>::min();
};

Range range_of(const HeightTile& tile, const Square& square) {
  Range range;
  for (int r = square.row; r <= square.row + square.cells; ++r) {
    for (int c = square.column; c <= square.column + square.cells; ++c) {
      if (tile.is_void(c, r)) continue;
      range.low = std::min(range.low, tile.at(c, r));
      range.high = std::max(range.high, tile.at(c, r));
    }
  }
  return range.low <= range.high ? range : Range{0, 0};
}

Relief relief_of_block(const HeightTile& tile, const Square& square, double quantum_m) {
  const Range range = range_of(tile, square);
  Relief relief{static_cast<float>(range.low * quantum_m), static_cast<float>(range.high * quantum_m), {}};
  double sum = 0;
  for (int k = 1; k <= kBlockCellsLog2; ++k) {
    sum += deviation_of_step(tile, square, 1 << (k - 1)) * quantum_m;
    relief.errors[static_cast<std::size_t>(k)] = static_cast<float>(sum);
  }
  return relief;
}

void include(Relief& whole, const Relief& part) {
  whole.low_m = std::min(whole.low_m, part.low_m);
  whole.high_m = std::max(whole.high_m, part.high_m);
  for (std::size_t k = 0; k < part.errors.size(); ++k) {
    whole.errors[k] = std::max(whole.errors[k], part.errors[k]);
  }
}

}  // namespace

int cells_log2_of(int tile_size) {
  assert(tile_size == 513 || tile_size == 257);
  return tile_size == 513 ? 9 : 8;
}

TileRelief relief_of(const HeightTile& tile, double quantum_m) {
  TileRelief relief;
  const int block = 1 << kBlockCellsLog2, cells = tile.size - 1;
  for (int row = 0; row < cells; row += block) {
    for (int column = 0; column < cells; column += block) {
      relief.blocks.push_back(relief_of_block(tile, {column, row, block}, quantum_m));
    }
  }
  relief.whole = relief.blocks.front();
  for (const Relief& part : relief.blocks) include(relief.whole, part);
  double sum = static_cast<double>(relief.whole.errors[kBlockCellsLog2]);
  for (int k = kBlockCellsLog2 + 1; k <= kMaxCellsLog2; ++k) {
    if (1 << k <= cells) sum += deviation_of_step(tile, {0, 0, cells}, 1 << (k - 1)) * quantum_m;
    relief.whole.errors[static_cast<std::size_t>(k)] = static_cast<float>(sum);
  }
  return relief;
}

const Relief& SurfaceTile::relief_under(const TileId& area) const {
  const int blocks_log2 = cells_log2_of(heights->size) - kBlockCellsLog2;
  const int deeper = area.level - id.level;
  if (deeper < blocks_log2) return relief.whole;
  const auto block_of = [&](std::int32_t of_area, std::int32_t of_tile) {
    const std::int64_t within = of_area - (static_cast<std::int64_t>(of_tile) << deeper);
    return static_cast<std::size_t>(within >> (deeper - blocks_log2));
  };
  return relief.blocks[(block_of(area.y, id.y) << blocks_log2) + block_of(area.x, id.x)];
}

HeightTexels height_texels(const HeightTile& tile) {
  const Range range = range_of(tile, {0, 0, tile.size - 1});
  const std::int64_t span = static_cast<std::int64_t>(range.high) - range.low;
  HeightTexels out;
  out.base = range.low;
  while ((span >> out.shift) >= kVoidTexel) ++out.shift;
  out.texels.resize(tile.samples.size());
  for (std::size_t i = 0; i < tile.samples.size(); ++i) {
    const bool gone = !tile.voids.empty() && tile.voids[i] != 0;
    const std::int64_t above = static_cast<std::int64_t>(tile.samples[i]) - range.low;
    out.texels[i] = gone ? kVoidTexel : static_cast<std::uint16_t>(above >> out.shift);
  }
  return out;
}

namespace {

/// Of the tile with only every 2^dropped-th row and column kept.
float thinned_height_at(const SurfaceTile& tile, const LatticePoint& point, int dropped) {
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
    if (heights.is_void(column, row)) return std::numeric_limits<double>::quiet_NaN();
    // Rounded as terrain.vert rounds it, so that a vertex is the same from either.
    return static_cast<double>(static_cast<float>(heights.at(column, row)) *
                               static_cast<float>(tile.quantum_m));
  };
  // A sample without weight is not read: it may be void, or beyond the tile.
  const double high = std::max(u, v), low = std::min(u, v);
  double height = metres(c, r);
  if (high == 0) return static_cast<float>(height);
  const double other = low == high ? height : u > v ? metres(c + 1, r) : metres(c, r + 1);
  height += (other - height) * high;
  if (low > 0) height += (metres(c + 1, r + 1) - other) * low;
  return static_cast<float>(height);
}

}  // namespace

float height_at(const SurfaceTile& tile, const LatticePoint& point) {
  return thinned_height_at(tile, point, 0);
}

ShownSurface ShownSurface::of(const SurfaceTile* tile, double detail) {
  if (!tile) return {};
  // With less than kMinLevel has, the end of the world would lie between samples.
  const int level = tile->id.level, least = std::max(level - cells_log2_of(tile->heights->size), kMinLevel);
  return {tile, std::clamp<double>(detail, least, level)};
}

int ShownSurface::whole_level() const {
  return static_cast<int>(std::floor(detail));
}

float height_at(const ShownSurface& surface, const LatticePoint& point) {
  const float finest = thinned_height_at(*surface.tile, point, 0);
  const int dropped = surface.tile->id.level - surface.whole_level();
  if (dropped == 0 || std::isnan(finest)) return finest;
  const auto known = [&](int rows_dropped) {
    float height = thinned_height_at(*surface.tile, point, rows_dropped);
    while (std::isnan(height)) height = thinned_height_at(*surface.tile, point, --rows_dropped);
    return height;
  };
  const auto part = static_cast<float>(surface.detail - surface.whole_level());
  const float coarse = known(dropped);
  return part > 0 ? coarse + (known(dropped - 1) - coarse) * part : coarse;
}

}  // namespace cairn::gl
