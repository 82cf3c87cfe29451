#include "builder/export/height_image.h"

#include <limits>

namespace cairn {

HeightImage image_of(const HeightTile& tile, const TileId& id, const PackHeader& header) {
  const GeoBounds bounds = tile_bounds(id);
  HeightImage image{
      tile.size, {}, bounds.west, bounds.north, bounds.width() / (tile.size - 1), header.vertical_datum};
  image.metres.reserve(tile.samples.size());
  for (int row = tile.size - 1; row >= 0; --row) {
    for (int column = 0; column < tile.size; ++column) {
      image.metres.push_back(tile.is_void(column, row) ? std::numeric_limits<double>::quiet_NaN()
                                                       : tile.at(column, row) * header.quantum_m);
    }
  }
  return image;
}

}  // namespace cairn
