#include "builder/mosaic/grid_placement.h"

#include <algorithm>
#include <cmath>

namespace cairn {
namespace {

constexpr double kCoincide = 0.01;  // of a post
constexpr double kSame = 1e-6;

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

}  // namespace cairn
