#include "builder/export/grid_index.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace cairn {
namespace {

constexpr std::size_t kFew = 8;

}  // namespace

GridIndex::GridIndex(std::span<const HeightSamples> grids, std::int64_t side)
    : cell_side_(static_cast<double>(side) / kCells), grids_(grids.size()) {
  if (grids_ <= kFew) {
    found_.resize(grids_);
    std::iota(found_.begin(), found_.end(), 0u);
    return;
  }
  cells_.resize(std::size_t{kCells} * kCells);
  for (std::uint32_t i = 0; i < grids_; ++i) {
    const HeightSamples& g = grids[i];
    if (g.columns == 0 || g.rows == 0) continue;
    const GridPlace last = g.place(g.columns - 1, g.rows - 1);
    for (int y = cell(static_cast<double>(g.row)); y <= cell(static_cast<double>(last.row)); ++y)
      for (int x = cell(static_cast<double>(g.column)); x <= cell(static_cast<double>(last.column)); ++x)
        cells_[static_cast<std::size_t>(y * kCells + x)].push_back(i);
  }
}

int GridIndex::cell(double at) const {
  return std::clamp(static_cast<int>(at / cell_side_), 0, kCells - 1);
}

const std::vector<std::uint32_t>& GridIndex::over(double west, double south, double east, double north) {
  if (cells_.empty()) return found_;
  found_.clear();
  for (int y = cell(south); y <= cell(north); ++y)
    for (int x = cell(west); x <= cell(east); ++x) {
      const auto& here = cells_[static_cast<std::size_t>(y * kCells + x)];
      found_.insert(found_.end(), here.begin(), here.end());
    }
  std::sort(found_.begin(), found_.end());
  found_.erase(std::unique(found_.begin(), found_.end()), found_.end());
  return found_;
}

}  // namespace cairn
