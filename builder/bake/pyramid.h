#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "builder/bake/tile_layer.h"
#include "builder/bake/tile_tree.h"

namespace cairn {

/// The parents under way: puts a tree of tiles together from its leaves, in the order of the tree's walk. Not
/// thread-safe.
template <TileLayer L>
class Pyramid {
 public:
  using Node = typename L::Node;

  /// REQUIRES: layer and tree outlive it.
  Pyramid(const L& layer, const TileTree& tree) : layer_(layer), tree_(tree) {}

  /// A parent whose children are all merged, and what is stored of them, in the order of their quadrants.
  struct Finished {
    Node parent;
    std::vector<TileBlock> children;
  };

  /// Merges a tile, pruned or encoded, into its parent. `stored` is what is stored of it, if anything.
  /// Returns the parent once its last child is merged.
  std::optional<Finished> merge(const Node& child, std::optional<TileBlock> stored) {
    const TileId parent_id = parent_of(child.id);
    if (open_.empty() || open_.back().node.id != parent_id)
      open_.push_back({layer_.begin_parent(parent_id), {}, tree_.children_of(parent_id)});
    OpenParent& open = open_.back();
    layer_.merge_child(child, open.node);
    if (stored) open.stored_children.push_back(std::move(*stored));
    if (--open.children_left > 0) return std::nullopt;
    Node parent = std::move(open.node);
    std::vector<TileBlock> stored_children = std::move(open.stored_children);
    open_.pop_back();
    layer_.finish_parent(parent);
    return Finished{std::move(parent), std::move(stored_children)};
  }

 private:
  struct OpenParent {
    Node node;
    std::vector<TileBlock> stored_children;
    int children_left = 0;
  };

  const L& layer_;
  const TileTree& tree_;
  std::vector<OpenParent> open_;  // each an ancestor of the next
};

}  // namespace cairn
