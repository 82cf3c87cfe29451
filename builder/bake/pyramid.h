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

  /// Merges a tile, pruned or encoded, into its parent. Returns the parent once its last child is merged.
  std::optional<Node> merge(const Node& child) {
    const TileId parent_id = parent_of(child.id);
    if (open_.empty() || open_.back().node.id != parent_id)
      open_.push_back({layer_.begin_parent(parent_id), tree_.children_of(parent_id)});
    layer_.merge_child(child, open_.back().node);
    if (--open_.back().children_left > 0) return std::nullopt;
    Node parent = std::move(open_.back().node);
    open_.pop_back();
    layer_.finish_parent(parent);
    return parent;
  }

 private:
  struct OpenParent {
    Node node;
    int children_left = 0;
  };

  const L& layer_;
  const TileTree& tree_;
  std::vector<OpenParent> open_;  // each an ancestor of the next
};

}  // namespace cairn
