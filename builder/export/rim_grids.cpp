#include "builder/export/rim_grids.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cairn {
namespace {

constexpr std::int64_t kBlockCells = 64;

/// Whether the coarse cell around a place has its four corners. Cells are counted from the world's
/// south-west.
class CoarseCells {
 public:
  CoarseCells(const MetreTile& tile, const TickRect& area, std::int64_t step)
      : tile_(tile), area_(area), step_(step) {}

  /// REQUIRES: the place is within the area; the cell to its north-east is meant.
  bool is_whole(std::int64_t x, std::int64_t y) const {
    const std::int64_t west = x / step_ * step_, south = y / step_ * step_;
    for (const std::int64_t cx : {west, west + step_})
      for (const std::int64_t cy : {south, south + step_}) {
        const bool is_in = cx >= area_.west && cx <= area_.east && cy >= area_.south && cy <= area_.north;
        if (!is_in || std::isnan(tile_.height_at(cx, cy))) return false;
      }
    return true;
  }

 private:
  const MetreTile& tile_;
  TickRect area_;
  std::int64_t step_;
};

/// The samples of a block of a fine tile that lie on a cell without a surface, every `step` ticks; empty
/// where there are none. Samples between them add their range to the error.
HeightSamples rim_of(const MetreTile& fine, const TickRect& block, std::int64_t fine_step, std::int64_t step,
                     const CoarseCells& coarse, const TickRect& rect) {
  HeightSamples grid;
  grid.column = block.west - rect.west;
  grid.row = block.south - rect.south;
  grid.step = step;
  grid.columns = static_cast<int>(block.width() / step) + 1;
  grid.rows = static_cast<int>(block.height() / step) + 1;
  const auto count = static_cast<std::size_t>(grid.columns) * static_cast<std::size_t>(grid.rows);
  std::vector<std::uint8_t> is_rim(count, 0);
  for (int r = 0; r + 1 < grid.rows; ++r)
    for (int c = 0; c + 1 < grid.columns; ++c) {
      if (coarse.is_whole(block.west + c * step, block.south + r * step)) continue;
      for (const int dc : {0, 1})
        for (const int dr : {0, 1}) is_rim[grid.index(c + dc, r + dr)] = 1;
    }
  if (std::find(is_rim.begin(), is_rim.end(), 1) == is_rim.end()) return {};
  double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
  grid.voids.assign(count, 1);
  grid.metres.assign(count, kElsewhere);
  for (std::int64_t y = block.south; y <= block.north; y += fine_step)
    for (std::int64_t x = block.west; x <= block.east; x += fine_step) {
      const double metres = fine.height_at(x, y);
      if (std::isnan(metres)) continue;
      lowest = std::min(lowest, metres);
      highest = std::max(highest, metres);
      if ((x - block.west) % step != 0 || (y - block.south) % step != 0) continue;
      const std::size_t i =
          grid.index(static_cast<int>((x - block.west) / step), static_cast<int>((y - block.south) / step));
      if (is_rim[i] == 0) continue;
      grid.metres[i] = static_cast<float>(metres);
      grid.voids[i] = 0;
    }
  if (!(lowest <= highest)) return {};
  if (step > fine_step) grid.error_m = highest - lowest;
  return grid;
}

}  // namespace

Result<double> add_rim(const QuantizedMeshSource& source, const GeographicTile& tile, const Patch& patch,
                       std::int64_t step, double wanted_m, RimGrids& out) {
  const TickRect rect = tile.rect(), area = intersection(patch.area, rect);
  const PackPatches::Range range = source.patches.range_over(area, kMaxLevel);
  const double spread = std::max(range.highest_m, 0.0) - std::min(range.lowest_m, 0.0) + range.error_m;
  if (spread <= wanted_m) return spread;
  const auto own = source.tiles.read(patch.entry);
  if (!own) return own.error();
  const CoarseCells coarse(**own, patch.area, step);
  // Only tiles with voids are entered: the corners of a coarse cell are samples of the finer tile too.
  for (const Patch& fine : source.patches.over_rims(area)) {
    const std::int64_t fine_step = tile_ticks(fine.entry.id.level) / ((*own)->size - 1);
    const std::int64_t rim_step = std::max(fine_step, lattice_step(tile.level, kRimOrder));
    if (rim_step >= step || (fine.entry.flags & kHasVoids) == 0) continue;
    const auto samples = source.tiles.read(fine.entry);
    if (!samples) return samples.error();
    TickRect within = intersection(fine.area, area);
    within.west = (within.west + rim_step - 1) / rim_step * rim_step;
    within.south = (within.south + rim_step - 1) / rim_step * rim_step;
    within.east = within.east / rim_step * rim_step;
    within.north = within.north / rim_step * rim_step;
    const std::int64_t side = kBlockCells * rim_step;
    for (std::int64_t south = within.south; south < within.north; south += side)
      for (std::int64_t west = within.west; west < within.east; west += side) {
        const TickRect block = intersection({west, south, west + side, south + side}, within);
        HeightSamples grid = rim_of(**samples, block, fine_step, rim_step, coarse, rect);
        if (grid.columns == 0) continue;
        grid.error_m += fine.error_m;
        extend_ground(grid, kElsewhere);
        out.finest_step = std::min(out.finest_step, rim_step);
        out.grids.push_back(std::move(grid));
      }
  }
  return 0.0;
}

void extend_ground(HeightSamples& grid, float beyond) {
  if (grid.voids.empty()) return;
  std::vector<float> extended(grid.metres.size());
  for (int r = 0; r < grid.rows; ++r)
    for (int c = 0; c < grid.columns; ++c) {
      const std::size_t i = grid.index(c, r);
      if (grid.voids[i] == 0) {
        extended[i] = grid.metres[i];
        continue;
      }
      double sum = 0;
      int count = 0;
      for (int y = std::max(r - 1, 0); y <= std::min(r + 1, grid.rows - 1); ++y)
        for (int x = std::max(c - 1, 0); x <= std::min(c + 1, grid.columns - 1); ++x)
          if (const std::size_t k = grid.index(x, y); grid.voids[k] == 0) {
            sum += static_cast<double>(grid.metres[k]);
            ++count;
          }
      extended[i] = count == 0 ? beyond : static_cast<float>(sum / count);
    }
  grid.metres = std::move(extended);
}

}  // namespace cairn
