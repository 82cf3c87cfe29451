#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "cairn/tile_id.h"
#include "runtime/scene/scene_map_spec.h"

namespace cairn {

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
