#pragma once

#include <vector>

#include "cairn/height_tile.h"

namespace cairn {

/// The roughness of every node of a tile's quadtree, finest level first, each level row by row from the
/// south: d2 = max |dh_i| / d over the midpoints of the node's four edges and two diagonals, d the node's
/// width in samples and dh the height above the straight line, in quanta; [4, eq. 5.5] after Röttger et al.
/// 1998. Then bottom-up a node's value is no less than half its children's, so that no neighbours differ by
/// more than one level. REQUIRES: size is 2^n + 1, n >= 1.
std::vector<float> roughness_of(const HeightTile& tile);

}  // namespace cairn
