#include "builder/export/height_image.h"

#include <algorithm>
#include <limits>

#include "builder/export/whole_metres.h"

namespace cairn {

HeightGrid grid_of(const HeightTile& tile, const TileId& id, const PackHeader& header) {
  const GeoBounds bounds = tile_bounds(id);
  const double spacing = bounds.width() / (tile.size - 1);
  HeightGrid grid{{tile.size, tile.size, bounds.west, bounds.north, spacing, spacing, header.body},
                  header.vertical_datum,
                  true};
  const HeightRows rows = rows_of(tile, header);
  std::vector<double> metres(static_cast<std::size_t>(tile.size));
  for (int row = 0; row < tile.size && grid.whole_metres; ++row) {
    (void)rows(row, metres);
    grid.whole_metres =
        std::all_of(metres.begin(), metres.end(), [](double m) { return m != m || whole_metres(m) == m; });
  }
  return grid;
}

HeightRows rows_of(const HeightTile& tile, const PackHeader& header) {
  return [&tile, quantum = header.quantum_m](int row, std::span<double> metres) -> Status {
    const int from_south = tile.size - 1 - row;
    for (int column = 0; column < tile.size; ++column)
      metres[static_cast<std::size_t>(column)] = tile.is_void(column, from_south)
                                                     ? std::numeric_limits<double>::quiet_NaN()
                                                     : tile.at(column, from_south) * quantum;
    return {};
  };
}

}  // namespace cairn
