#include "runtime/gl/surface_tile.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace cairn::gl {
namespace {

/// The largest deviation of samples at odd multiples of `step` from the triangles through the even ones.
double deviation_of_step(const HeightTile& tile, int step) {
  std::int64_t twice_worst = 0;
  const auto compare = [&](int c, int r, int dc, int dr) {
    const std::int64_t ends = static_cast<std::int64_t>(tile.at(c - dc, r - dr)) + tile.at(c + dc, r + dr);
    twice_worst = std::max(twice_worst, std::abs(ends - 2 * static_cast<std::int64_t>(tile.at(c, r))));
  };
  for (int r = 0; r < tile.size; r += step) {
    const bool odd_row = (r / step) % 2 == 1;
    for (int c = odd_row ? 0 : step; c < tile.size; c += odd_row ? step : 2 * step) {
      const bool odd_column = (c / step) % 2 == 1;
      compare(c, r, odd_column ? step : 0, odd_row ? step : 0);
    }
  }
  return static_cast<double>(twice_worst) / 2;
}

struct Range {
  std::int32_t low = std::numeric_limits<std::int32_t>::max();
  std::int32_t high = std::numeric_limits<std::int32_t>::min();
};

Range range_of(const HeightTile& tile) {
  Range range;
  for (std::size_t i = 0; i < tile.samples.size(); ++i) {
    if (!tile.voids.empty() && tile.voids[i] != 0) continue;
    range.low = std::min(range.low, tile.samples[i]);
    range.high = std::max(range.high, tile.samples[i]);
  }
  return range.low <= range.high ? range : Range{0, 0};
}

}  // namespace

int cells_log2_of(int tile_size) {
  assert(tile_size == 513 || tile_size == 257);
  return tile_size == 513 ? 9 : 8;
}

DecimationErrors decimation_errors(const HeightTile& tile, double quantum_m) {
  DecimationErrors errors{};
  double sum = 0;
  const int steps = cells_log2_of(tile.size);
  for (int k = 1; k <= kMaxCellsLog2; ++k) {
    if (k <= steps) sum += deviation_of_step(tile, 1 << (k - 1)) * quantum_m;
    errors[static_cast<std::size_t>(k)] = static_cast<float>(sum);
  }
  return errors;
}

HeightTexels height_texels(const HeightTile& tile, double quantum_m) {
  const Range range = range_of(tile);
  const std::int64_t span = static_cast<std::int64_t>(range.high) - range.low;
  int shift = 0;
  while ((span >> shift) >= kVoidTexel) ++shift;
  HeightTexels out;
  out.base_m = static_cast<float>(range.low * quantum_m);
  out.scale_m = static_cast<float>(std::ldexp(quantum_m, shift));
  out.high_m = static_cast<float>(range.high * quantum_m);
  out.texels.resize(tile.samples.size());
  for (std::size_t i = 0; i < tile.samples.size(); ++i) {
    const bool gone = !tile.voids.empty() && tile.voids[i] != 0;
    const std::int64_t above = static_cast<std::int64_t>(tile.samples[i]) - range.low;
    out.texels[i] = gone ? kVoidTexel : static_cast<std::uint16_t>(above >> shift);
  }
  return out;
}

LatticePoint south_west_of(const TileId& id) {
  const std::int64_t width = lattice_width(id.level);
  return {id.x * width, id.y * width};
}

float height_at(const SurfaceTile& tile, const LatticePoint& point) {
  const HeightTile& heights = *tile.heights;
  const int cells_log2 = cells_log2_of(heights.size);
  const std::int64_t spacing = lattice_width(tile.id.level + cells_log2);
  const LatticePoint origin = south_west_of(tile.id);
  const std::int64_t dx = point.x - origin.x, dy = point.y - origin.y;
  assert(dx >= 0 && dy >= 0 && dx <= spacing << cells_log2 && dy <= spacing << cells_log2);
  const auto c = static_cast<int>(dx / spacing), r = static_cast<int>(dy / spacing);
  const double u = static_cast<double>(dx % spacing) / static_cast<double>(spacing);
  const double v = static_cast<double>(dy % spacing) / static_cast<double>(spacing);
  const auto metres = [&](int column, int row) {
    if (heights.is_void(column, row)) return std::numeric_limits<double>::quiet_NaN();
    return heights.at(column, row) * tile.quantum_m;
  };
  const auto along = [&](int row) {
    const double west = metres(c, row);
    return u == 0 ? west : west + (metres(c + 1, row) - west) * u;
  };
  const double south = along(r);
  return static_cast<float>(v == 0 ? south : south + (along(r + 1) - south) * v);
}

}  // namespace cairn::gl
