#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "cairn/bounding_volume.h"
#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// What encloses the surface over a square, and its heights.
struct SquareVolume {
  BoundingVolume volume;
  double low_m = 0;
  double high_m = 0;
};

/// The volumes of a tile's squares of 2^k cells, from a least k to the whole tile.
class SquareVolumes {
 public:
  /// REQUIRES: least >= 0. Where the tile has fewer cells, it is the only square.
  SquareVolumes(const LodScene& scene, const LodTile& tile, int least);

  int levels() const { return levels_; }  ///< log2 of the tile's cells
  int least() const { return least_; }
  /// (x, y) counts squares of 2^k cells from the tile's south-west corner. A square outside the world, in a
  /// tile that overhangs it, has no volume. REQUIRES: least() <= k <= levels().
  const SquareVolume& at(int k, int x, int y) const {
    return volumes_[static_cast<std::size_t>(k - least_)]
                   [(static_cast<std::size_t>(y) << (levels_ - k)) + static_cast<std::size_t>(x)];
  }

  std::uint64_t bytes() const;

 private:
  void measure(const HeightTile& heights, double quantum_m);
  void place(const TileId& id, const Occluder& occluder);

  int levels_;
  int least_;
  std::vector<std::vector<SquareVolume>> volumes_;  ///< by k - least
};

}  // namespace cairn
