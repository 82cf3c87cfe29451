#pragma once

#include "cairn/height_tile.h"

namespace cairn {

/// Gives the void samples of a tile a height that codecs see no cliff at: the last one to the west in the
/// row, else the row's first, else one of the row south of it (in the southernmost rows, the tile's first). 0
/// where all is void.
void fill_void_samples(HeightTile& tile);

}  // namespace cairn
