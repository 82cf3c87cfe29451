#pragma once

#include <vector>

#include "cairn/height_tile.h"

namespace cairn {

/// Returns the roughness of every node of a tile's quadtree (Melkisetoğlu 2005, eq. 5.5, after Röttger et al.
/// 1998). The finest level comes first, each level row by row from the south.
///
/// It is d2 = max |dh_i| / d over the midpoints of the node's four edges and two diagonals, d the node's
/// width in samples and dh the height above the straight line, in quanta. Bottom-up, a node's value is made
/// no less than half its children's, so that neighbours differ by at most one level. REQUIRES: size is 2^n +
/// 1, n >= 1.
std::vector<float> roughness_of(const HeightTile& tile);

}  // namespace cairn
