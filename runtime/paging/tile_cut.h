#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cairn/bounding_volume.h"
#include "cairn/loaded_tile.h"
#include "runtime/scene/scene_map.h"

namespace cairn {

class TileAvailability;

/// An area of the Earth and the tiles that show it: its own, or windows of coarser ones.
struct CutNode {
  TileId area;
  std::optional<IndexEntry> heights;
  std::optional<IndexEntry> imagery;
  BoundingVolume volume;

  bool shows_same(const CutNode& other) const {
    return area == other.area && heights == other.heights && imagery == other.imagery;
  }
  /// Calls `use` with the index entry of each tile that the area shows.
  template <class Use>
  void for_each_source(Use use) const {
    if (heights) use(*heights);
    if (imagery) use(*imagery);
  }
};

/// The whole Earth, each place once, depth first: a tile's children south-west, south-east, north-west,
/// north-east, in its place.
using TileCut = std::vector<CutNode>;

/// The area with the best that the pack can show there. With `has_finer_heights` the volume encloses these,
/// too, by the error of the coarser ones.
CutNode make_cut_node(const TileId& area, const TileAvailability& contents, const Occluder& occluder,
                      bool has_finer_heights);

/// A smallest area on which two covers differ: one tile of the one, one or more of the other.
struct CutChange {
  std::size_t old_first = 0;
  std::size_t old_count = 0;
  std::size_t new_first = 0;
  std::size_t new_count = 0;

  bool coarsens() const { return old_count > 1; }
  bool refines() const { return new_count > 1; }
};

/// Every change from one cover of the Earth to another, depth first.
std::vector<CutChange> changes_between(const TileCut& before, const TileCut& after);

}  // namespace cairn
