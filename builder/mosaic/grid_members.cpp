#include "builder/mosaic/grid_members.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace cairn {
namespace {

constexpr double kCoincide = 0.01;  // of a post
constexpr double kSame = 1e-6;

std::int64_t floor_divide(std::int64_t a, std::int64_t b) {
  return a / b - (a % b < 0 ? 1 : 0);
}

bool overlap(const IndexWindow& a, const IndexWindow& b) {
  return a.x.first <= b.x.last && b.x.first <= a.x.last && a.y.first <= b.y.last && b.y.first <= a.y.last;
}

// Cells are numbered in one number, as nobody has 2^31 of them along an axis.
std::int64_t number_of(std::int64_t x, std::int64_t y) {
  return y * (std::int64_t{1} << 32) + x;
}

}  // namespace

std::optional<GridPlacement> place_on_grid(const RasterInfo& info, const Georeference& grid) {
  const Georeference& own = info.georeference;
  if (!own.has_crs_of(grid)) return std::nullopt;
  const auto post_of = [&](double column, double row) {
    return grid.post_at_coordinate(own.coordinate_of(column, row));
  };
  const auto first = post_of(0, 0);
  const double column = std::round(first.column), row = std::round(first.row);
  if (!(std::abs(column) < 1e15 && std::abs(row) < 1e15)) return std::nullopt;
  const double c = static_cast<double>(info.columns - 1), r = static_cast<double>(info.rows - 1);
  double farthest = 0;
  for (const auto& corner : {std::pair{0., 0.}, {c, 0.}, {0., r}, {c, r}}) {
    const auto at = post_of(corner.first, corner.second);
    farthest = std::max(
        {farthest, std::abs(at.column - column - corner.first), std::abs(at.row - row - corner.second)});
  }
  if (!(farthest <= kCoincide)) return std::nullopt;
  return GridPlacement{static_cast<std::int64_t>(column), static_cast<std::int64_t>(row), farthest > kSame};
}

GridMembers::GridMembers(std::vector<IndexWindow> extents) : extents_(std::move(extents)) {
  assert(!extents_.empty());
  hull_ = extents_.front();
  std::int64_t sides = 0;
  for (const IndexWindow& e : extents_) {
    hull_ = {{std::min(hull_.x.first, e.x.first), std::max(hull_.x.last, e.x.last)},
             {std::min(hull_.y.first, e.y.first), std::max(hull_.y.last, e.y.last)}};
    sides += std::max(e.x.count(), e.y.count());
  }
  // About as large as a member, so that each lies in a few cells.
  cell_ = std::max<std::int64_t>({sides / static_cast<std::int64_t>(extents_.size()),
                                  std::max(hull_.x.count(), hull_.y.count()) / 1024, 64});
  for (std::size_t m = 0; m < extents_.size(); ++m) {
    const IndexWindow cells = cells_of(extents_[m]);
    for (std::int64_t y = cells.y.first; y <= cells.y.last; ++y) {
      for (std::int64_t x = cells.x.first; x <= cells.x.last; ++x)
        by_cell_[number_of(x, y)].push_back(static_cast<std::uint32_t>(m));
    }
  }
}

IndexWindow GridMembers::cells_of(const IndexWindow& w) const {
  return {{floor_divide(w.x.first, cell_), floor_divide(w.x.last, cell_)},
          {floor_divide(w.y.first, cell_), floor_divide(w.y.last, cell_)}};
}

std::vector<std::size_t> GridMembers::overlapping(const IndexWindow& window) const {
  const IndexWindow within{{std::max(window.x.first, hull_.x.first), std::min(window.x.last, hull_.x.last)},
                           {std::max(window.y.first, hull_.y.first), std::min(window.y.last, hull_.y.last)}};
  std::vector<std::size_t> found;
  if (within.x.count() <= 0 || within.y.count() <= 0) return found;
  const IndexWindow cells = cells_of(within);
  for (std::int64_t y = cells.y.first; y <= cells.y.last; ++y) {
    for (std::int64_t x = cells.x.first; x <= cells.x.last; ++x) {
      const auto cell = by_cell_.find(number_of(x, y));
      if (cell == by_cell_.end()) continue;
      for (const std::uint32_t m : cell->second)
        if (overlap(extents_[m], within)) found.push_back(m);
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

}  // namespace cairn
