#pragma once

#include <cassert>
#include <cstddef>

#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// The window of a tile's source that covers its area. Sample (0, 0) is the area's south-west corner.
class TileWindow {
 public:
  TileWindow(const LodScene& scene, const LodTile& tile)
      : heights_(tile.heights.get()), quantum_m_(scene.quantum_m), origin_(south_west_of(tile.area)) {
    const int deeper = tile.area.level - tile.source.level;
    cells_ = (scene.tile_size - 1) >> deeper;
    assert(cells_ >= 1 && heights_->size == scene.tile_size);
    spacing_ = lattice_width(tile.source.level) / (scene.tile_size - 1);
    const LatticePoint corner = south_west_of(tile.source);
    column_ = static_cast<int>((origin_.x - corner.x) / spacing_);
    row_ = static_cast<int>((origin_.y - corner.y) / spacing_);
  }

  int cells() const { return cells_; }    ///< intervals along a side, a power of two
  int column() const { return column_; }  ///< the column of the source where the window begins
  int row() const { return row_; }
  std::int64_t spacing() const { return spacing_; }  ///< between samples, in lattice units
  LatticePoint point(int c, int r) const { return {origin_.x + c * spacing_, origin_.y + r * spacing_}; }
  std::int32_t quanta(int c, int r) const { return heights_->at(column_ + c, row_ + r); }
  double height_m(int c, int r) const { return quanta(c, r) * quantum_m_; }
  LodVertex vertex(int c, int r) const { return {point(c, r), height_m(c, r)}; }

 private:
  const HeightTile* heights_;
  double quantum_m_;
  LatticePoint origin_;
  std::int64_t spacing_ = 0;
  int cells_ = 0;
  int column_ = 0;
  int row_ = 0;
};

}  // namespace cairn
