#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/paging/tile_selection.h"
#include "runtime/paging/tile_tree.h"

namespace cairn {

/// The tiles of objects that views need.
struct ObjectSelection {
  std::vector<IndexEntry> tiles;  ///< the largest on the screen first
  std::uint64_t bytes = 0;        ///< that they may take in memory
  std::size_t absent = 0;         ///< tiles that are needed too, but cannot be read
  bool is_limited = false;        ///< the budget ended it
};

/// Returns the tiles that may have an object which some view sees larger than `smallest_px`. Outside the
/// views sixteen times that counts, so that a turn of an eye finds what is near.
///
/// An object is in one tile only, so that nothing stands for a tile that is not selected. The entry of a tile
/// says how large its objects and those beneath it are.
ObjectSelection select_objects(const TileTree& tree, std::span<const SelectionView> views, double smallest_px,
                               std::uint64_t budget_bytes);

}  // namespace cairn
