#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "builder/baked_tile.h"
#include "builder/build_plan.h"
#include "format/pack_layout.h"
#include "format/status.h"

namespace cairn {

/// A tile to be stored; no block where it is constant.
struct TileBlock {
  IndexEntry entry;
  std::vector<std::byte> block;
};

/// Puts a tree of tiles together from its leaves, in the order of the plan's walk, and hands out the tiles to
/// be stored: a tile is left out where its parent's surface is within the promise of every post and none of
/// its descendants is stored. Not thread-safe.
class Pyramid {
 public:
  using Emit = std::function<Status(TileBlock&&)>;

  /// Tiles coarser than `root_level` are left to another pyramid. REQUIRES: the plan outlives the pyramid.
  Pyramid(const BuildPlan& plan, int root_level, Emit emit);

  /// Takes the next leaf or finished subtree. Gives back the root when this completes it.
  Result<std::optional<BakedTile>> add(BakedTile child);

  /// Emits the tile, unless it is left out. For roots: add() does it for all others.
  Status settle(BakedTile& tile);

 private:
  struct OpenParent {
    BakedTile parent;
    int waiting_for = 0;
    int children = 0;
  };
  void take(const BakedTile& child, OpenParent& into) const;

  const BuildPlan& plan_;
  int root_level_;
  Emit emit_;
  std::vector<OpenParent> open_;
};

}  // namespace cairn
