#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

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

/// Returns whether a tile is available: it is in the pack and not known to be damaged. Null for all tiles.
/// Called once for each node of the map's tree, ancestors included.
using HasTile = std::function<bool(const TileId&)>;

/// A leaf of the map: an area, and the tile whose data is drawn there.
struct SceneTile {
  static constexpr std::int8_t kNothing = -128;

  TileId area;
  /// The level of the nearest available tile among the area's own and its ancestors; kNothing if there is
  /// none.
  std::int8_t source_level = kNothing;

  bool has_source() const { return source_level != kNothing; }
  /// REQUIRES: has_source().
  TileId source() const { return ancestor_of(area, source_level); }

  friend auto operator<=>(const SceneTile&, const SceneTile&) = default;
};

/// Tiles of mixed levels that cover the scene, each place once. Sorted by area.
using SceneMap = std::vector<SceneTile>;

/// Returns the scene map of a spec. Where all children of an area would show one coarser tile, the map has
/// the area itself. Equal specs and equal answers of `has` give equal maps. REQUIRES: a valid spec.
SceneMap build_scene_map(const SceneMapSpec& spec, const HasTile& has = nullptr);

/// Returns the tiles whose data the map shows: sorted, each once.
std::vector<TileId> sources_of(const SceneMap& map);

/// Returns the difference blocks (Melkisetoğlu 2005, §8.6): the tiles of `after` that `before` has not. All
/// sorted.
std::vector<TileId> difference(std::span<const TileId> before, std::span<const TileId> after);

}  // namespace cairn
