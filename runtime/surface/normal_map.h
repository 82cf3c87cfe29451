#pragma once

#include <cstddef>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/surface.h"
#include "cairn/tile_id.h"

namespace cairn {

/// The normals of a tile's cells in signed BC5: the east and north parts of the unit normal; up is what is
/// left. Texel (i, j) is the normal of the cell east of column i and north of row j, rows from SOUTH to
/// north, so that lighting has a tile's full detail whatever is drawn of its mesh (Intel 2012, "Normal Map
/// Compression"). kNormalMips levels follow each other, each averaging 2×2 normals of the one before.
std::vector<std::byte> normal_map(const TileId& id, const HeightTile& tile, double quantum_m,
                                  const Ellipsoid& ellipsoid);

}  // namespace cairn
