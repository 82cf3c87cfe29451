#pragma once

#include "cairn/refinement_pattern.h"
#include "cairn/tile_id.h"

namespace cairn {

/// Everything that a scene map depends on, beside the tiles that exist.
///
/// At each level finer than `coarsest - 1` the pattern selects the tiles to split; the map is the leaves. In
/// `restricted`, at each level l the parents of the eye's tile at l and of its 4 diagonal neighbours at l are
/// split, so that a 4×4 group of level-l tiles surrounds the eye.
///
/// The 4×4 groups lie on even tile numbers and the next finer group (2×2 tiles of this level) need not be in
/// their middle, so that its rim may touch the level after next; at K >= 3 that happens at 15 of 16 eye
/// tiles. No rule with 4×4 groups avoids it: the 2×2 would have to begin at an odd number at every level.
/// `balanced` has a difference of one, at the cost of up to 102 tiles and 46 new ones per move (K = 4).
///
/// Beside the antimeridian the tiles of levels coarser than -3 overhang the world and do not line up with
/// those across it: there `restricted` may step by more, `balanced` does not.
///
/// The longitude wraps; in latitude a neighbour beyond the pole is replaced by the tile at the pole.
struct SceneMapSpec {
  TileId eye;                ///< the eye's tile at the finest level; valid
  int coarsest = kMinLevel;  ///< kMinLevel covers the whole Earth; f-K+1 gives the K levels that are counted
  RefinementPattern pattern = RefinementPattern::restricted;
  int window_tiles = 8;  ///< n of RefinementPattern::window; 1…64
};

}  // namespace cairn
