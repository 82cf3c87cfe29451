#pragma once

#include <array>
#include <vector>

#include "cairn/tile_id.h"
#include "runtime/scene/scene_map_spec.h"

namespace cairn {

/// The inner nodes of a scene map's tree. There are so few per level that a list per level is the fastest
/// set.
class SplitSet {
 public:
  bool contains(const TileId& id) const;
  /// Adds the tile if it is new; returns whether it was.
  bool insert(const TileId& id);
  const std::vector<TileId>& at(int level) const { return levels_[index(level)]; }

 private:
  static std::size_t index(int level) { return static_cast<std::size_t>(level - kMinLevel); }
  std::array<std::vector<TileId>, kMaxLevel - kMinLevel + 1> levels_;
};

/// Returns the tiles that the spec's pattern splits, with their parents, from level max(coarsest - 1,
/// kMinLevel) to the level before the camera's. REQUIRES: a pattern of several levels.
SplitSet mark_splits(const SceneMapSpec& spec);

}  // namespace cairn
