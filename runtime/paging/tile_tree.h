#pragma once

#include <cstddef>
#include <cstdint>
#include <unordered_map>

#include "runtime/paging/tile_availability.h"
#include "runtime/paging/tile_cut.h"

namespace cairn {

/// The quadtree of a pack's tiles: what each area can show at best and what there is below it. Nodes are
/// worked out when they are asked for, and kept, since the bounding volume takes longer than all the rest.
/// One thread only.
class TileTree {
 public:
  struct Node {
    CutNode best;  ///< what shows the area best; the volume encloses all finer heights, too
    bool has_finer_heights = false;
    bool has_finer_imagery = false;
    bool is_above_tiles = false;  ///< see TileAvailability
  };

  /// `contents` must outlive the tree.
  TileTree(const TileAvailability& contents, const Occluder& occluder)
      : contents_(contents), occluder_(occluder) {}

  const TileAvailability& contents() const { return contents_; }
  /// Returns the node of an area, which holds until the next forget() or trim().
  const Node& node(const TileId& area) const;

  /// Drops all nodes: what the pack can show has changed.
  void forget() { nodes_.clear(), older_.clear(); }
  /// Drops the nodes that were not asked for lately, if there are many.
  void trim();

 private:
  bool has_children(Layer layer, const TileId& area) const;

  const TileAvailability& contents_;
  const Occluder occluder_;
  mutable std::unordered_map<TileId, Node> nodes_;
  mutable std::unordered_map<TileId, Node> older_;  // not asked for since the last trim
};

}  // namespace cairn
