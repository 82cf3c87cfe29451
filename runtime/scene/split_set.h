#pragma once

#include <array>
#include <vector>

#include "cairn/tile_id.h"

namespace cairn {

struct SceneMapSpec;

/// The inner nodes of a scene map's tree: a handful of tiles a level, so that a flat list a level is the
/// fastest set.
class SplitSet {
 public:
  bool contains(const TileId& id) const;
  /// Adds the tile unless it is there; whether it was new.
  bool insert(const TileId& id);
  const std::vector<TileId>& at(int level) const { return levels_[index(level)]; }

 private:
  static std::size_t index(int level) { return static_cast<std::size_t>(level - kMinLevel); }
  std::array<std::vector<TileId>, kMaxLevel - kMinLevel + 1> levels_;
};

/// The tiles that the spec's pattern splits, from level coarsest-1 (kMinLevel at least) to the eye's level
/// less one. With a tile its parent is there too. REQUIRES: a pattern of several levels.
SplitSet mark_splits(const SceneMapSpec& spec);

}  // namespace cairn
