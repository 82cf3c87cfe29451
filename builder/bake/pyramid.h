#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <utility>
#include <vector>

#include "builder/bake/tile_tree.h"
#include "cairn/pack_layout.h"
#include "cairn/status.h"

namespace cairn {

/// A tile to be stored; no block where it is constant.
struct TileBlock {
  IndexEntry entry;
  std::vector<std::byte> block;
};

/// Puts a tree of tiles together from its leaves, in the order of the tree's walk, and hands out the tiles to
/// be stored. Not thread-safe. What tiles are is the layer's: it has
///   TileLayer::Tile                                            with a member `id`,
///   Tile open_parent(const TileId&) const                  before its children are in,
///   void take(const Tile& child, Tile&) const              puts a child into its parent,
///   void close_parent(Tile&) const                         once all are in,
///   Result<std::optional<TileBlock>> settle(Tile&) const   what is stored of a tile, if it is; then its
///                                                          parent takes it.
template <class TileLayer>
class Pyramid {
 public:
  using Tile = typename TileLayer::Tile;
  using Emit = std::function<Status(TileBlock&&)>;

  /// Tiles coarser than `root_level` are left to another pyramid. REQUIRES: layer and tree outlive it.
  Pyramid(const TileLayer& layer, const TileTree& tree, int root_level, Emit emit)
      : layer_(layer), tree_(tree), root_level_(root_level), emit_(std::move(emit)) {}

  /// Takes the next leaf or finished subtree. Gives back the root, settled, when this completes it.
  /// REQUIRES: `child` is settled.
  Result<std::optional<Tile>> add(Tile child) {
    while (child.id.level > root_level_) {
      const TileId parent_id = parent_of(child.id);
      if (open_.empty() || open_.back().parent.id != parent_id)
        open_.push_back({layer_.open_parent(parent_id), tree_.children_of(parent_id)});
      OpenParent& into = open_.back();
      layer_.take(child, into.parent);
      if (--into.waiting_for > 0) return std::optional<Tile>{};
      layer_.close_parent(into.parent);
      child = std::move(into.parent);
      open_.pop_back();
      if (auto status = settle(child); !status) return status.error();
    }
    return std::optional<Tile>(std::move(child));
  }

  /// Emits the tile, unless it is left out. For leaves: add() does it for all others.
  Status settle(Tile& tile) {
    auto block = layer_.settle(tile);
    if (!block) return block.error();
    return *block ? emit_(std::move(**block)) : Status();
  }

 private:
  struct OpenParent {
    Tile parent;
    int waiting_for = 0;
  };

  const TileLayer& layer_;
  const TileTree& tree_;
  int root_level_;
  Emit emit_;
  std::vector<OpenParent> open_;
};

}  // namespace cairn
