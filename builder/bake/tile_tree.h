#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "cairn/tile_id.h"

namespace cairn {

/// The tiles of one layer of a bake, decided before anything is read. The tree is walked depth first,
/// children in the order of their quadrants, parents after their children: a space-filling order.
class TileTree {
 public:
  /// The level at which a tile's area has to be sampled, wherever in the tile that is finest; nullopt where
  /// the layer has nothing in the tile. A tile's is never coarser than its descendants'.
  using LeafLevel = std::function<std::optional<int>(const TileId&)>;

  /// Whether the layer has something on the tile's edge, if not inside it.
  using Touches = std::function<bool(const TileId&)>;

  /// `top` is the coarsest level. Tiles that are only touched lend their edges to their parents, so that two
  /// parents on a line where the layer begins have the same samples there; they are never stored.
  TileTree(int top, LeafLevel leaf_level, Touches touches = {})
      : top_(top), leaf_level_(std::move(leaf_level)), touches_(std::move(touches)) {}

  int top() const { return top_; }

  /// Whether the bake makes the tile or descendants of it.
  bool wants(const TileId& id) const;
  /// Whether the tile is sampled, not put together from its children. REQUIRES: wants(id).
  bool is_leaf(const TileId& id) const;
  /// Whether the tile only lends its edge.
  bool edge_only(const TileId& id) const;
  /// How many of its children are walked: wanted, or lending an edge.
  int children_of(const TileId& id) const;

  /// Subtrees of at most 16 leaves, in the order of the walk: what one task does.
  std::vector<TileId> units() const;
  /// Those of one subtree, whose root is no finer than a unit's.
  std::vector<TileId> units(const TileId& subtree) const;
  /// The leaves of a unit, in the order of the walk.
  std::vector<TileId> leaves(const TileId& unit) const;
  std::uint64_t leaf_count() const;
  std::map<int, std::uint64_t> tiles_by_level() const;

 private:
  int finest_within(const TileId& id) const;
  bool is_walked(const TileId& id) const { return wants(id) || edge_only(id); }
  template <class Visit>
  void walk(const TileId& id, const Visit& visit) const;

  int top_;
  LeafLevel leaf_level_;
  Touches touches_;
};

}  // namespace cairn
