#pragma once

#include <vector>

#include "builder/bake/tile_tree.h"
#include "builder/shard/shard_plan.h"
#include "cairn/build_options.h"

namespace cairn {

/// The tiles of each of so many shards, of about equal cost.
struct DividedTiles {
  std::vector<ShardTiles> heights;
  std::vector<ShardTiles> imagery;
};

/// Divides the layers' units along the Z curve that all trees are walked on, so that a shard's tiles of both
/// layers lie at one place. Either tree may be null. Each shard's units are stated as the largest subtrees
/// that it has to itself.
DividedTiles divide_tiles(const TileTree* heights, const TileTree* imagery, std::size_t shards);

/// All units of a shard's subtrees, in the order of the tree's walk.
std::vector<TileId> units_of(const TileTree& tree, const ShardTiles& tiles);

}  // namespace cairn
