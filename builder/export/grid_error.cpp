#include "builder/export/grid_error.h"

#include <algorithm>
#include <cmath>

namespace cairn {
namespace {

struct Part {
  std::int64_t first, last;
};

/// The samples of a tile that lie in its area and in the rectangle, along one axis.
Part samples_in(std::int64_t origin, std::int64_t step, std::int64_t low_a, std::int64_t low_b,
                std::int64_t high_a, std::int64_t high_b) {
  return {(std::max(low_a, low_b) - origin + step - 1) / step, (std::min(high_a, high_b) - origin) / step};
}

}  // namespace

double DecodedGrid::at(double column, double row) const {
  const int c = std::min(static_cast<int>(column), columns - 2),
            r = std::min(static_cast<int>(row), rows - 2);
  const double u = column - c, v = row - r;
  const auto post = [&](int i, int j) {
    return metres[static_cast<std::size_t>(j) * static_cast<std::size_t>(columns) +
                  static_cast<std::size_t>(i)];
  };
  return (post(c, r) * (1 - u) + post(c + 1, r) * u) * (1 - v) +
         (post(c, r + 1) * (1 - u) + post(c + 1, r + 1) * u) * v;
}

TickRect ticks_around(const GeoBounds& b) {
  const auto tick = [](double degrees, double origin, double (*snap)(double)) {
    return static_cast<std::int64_t>(snap(std::ldexp(degrees - origin, kTickBits)));
  };
  return {tick(b.west, -180, std::floor), tick(b.south, -90, std::floor), tick(b.east, -180, std::ceil),
          tick(b.north, -90, std::ceil)};
}

Result<double> grid_error(const PackPatches& patches, MetreTiles& tiles, const VerticalShift& shift,
                          const TickRect& rect, int finest, const DecodedGrid& grid,
                          const std::function<GridPosition(LonLat)>& position) {
  double worst = 0;
  for (const Patch& patch : patches.over(rect, 0, finest)) {
    const auto read = tiles.read(patch.entry);
    if (!read) return read.error();
    const MetreTile& tile = **read;
    const TickRect own = ticks_of(tile.id);
    const std::int64_t step = tile_ticks(tile.id.level) / (tile.size - 1);
    const Part rows = samples_in(own.south, step, patch.area.south, rect.south, patch.area.north, rect.north);
    const Part columns = samples_in(own.west, step, patch.area.west, rect.west, patch.area.east, rect.east);
    for (std::int64_t r = rows.first; r <= rows.last; ++r) {
      for (std::int64_t c = columns.first; c <= columns.last; ++c) {
        const auto metres = static_cast<double>(tile.at(static_cast<int>(c), static_cast<int>(r)));
        if (std::isnan(metres)) continue;
        const LonLat place = place_of(own.west + c * step, own.south + r * step);
        const GridPosition at = position(place);
        if (!(at.column >= 0 && at.column <= grid.columns - 1 && at.row >= 0 && at.row <= grid.rows - 1))
          continue;
        worst =
            std::max(worst, std::abs(grid.at(at.column, at.row) - metres - shift.at(place)) + patch.error_m);
      }
    }
  }
  return worst;
}

}  // namespace cairn
