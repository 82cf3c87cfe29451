#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/tile_id.h"
#include "runtime/surface/axis_table.h"
#include "runtime/surface/vertex_steps.h"
#include "runtime/view/sample_lattice.h"
#include "runtime/view/screen_error_budget.h"

namespace cairn {

/// The largest log2 of intervals along a tile's side: 513 samples.
inline constexpr int kMaxCellsLog2 = 9;

/// Returns log2 of the intervals along the side of a tile: 9 or 8. REQUIRES: 513 or 257.
int cells_log2_of(int tile_size);

/// Upper bounds, in metres, of the distance between a tile's surface and the surface that is left of it when
/// only every 2^k-th row and column are kept, k = 0…9.
///
/// A bound is the sum over the steps of the largest deviation that the step adds. Entries beyond the tile's
/// last step repeat it.
using DecimationErrors = std::array<float, kMaxCellsLog2 + 1>;
DecimationErrors decimation_errors(const HeightTile& tile, double quantum_m);

/// The spheres around the squares of a tile: its own, its quarters, and so on down to kLeastCellsLog2.
class SquareSpheres {
 public:
  static constexpr int kLeastCellsLog2 = 4;

  SquareSpheres() = default;
  SquareSpheres(const HeightTile& tile, const TileId& id, double quantum_m, const Ellipsoid& ellipsoid);

  /// REQUIRES: the tile covers the area, which is no smaller than the least square.
  const SquareSphere& around(const TileId& area) const;

  std::uint64_t bytes() const { return spheres_.size() * sizeof(SquareSphere); }

 private:
  TileId id_;
  int levels_ = -1;  // from the tile to the squares of 2^kLeastCellsLog2 cells
  std::array<std::size_t, kMaxCellsLog2 + 1> first_{};
  std::vector<SquareSphere> spheres_;
};

/// A tile of heights and what the surface needs of it, worked out once when the tile is loaded.
struct SurfaceTile {
  TileId id;
  std::shared_ptr<const HeightTile> heights;
  double quantum_m = 0;

  HeightRange range;  ///< quanta
  DecimationErrors errors{};
  VertexSteps steps;
  SquareSpheres spheres;
  std::vector<ColumnEntry> columns;
  std::vector<RowEntry> rows;

  /// Of memory, without the heights.
  std::uint64_t bytes() const;
};

/// Prepares a tile; takes some 15 ms for 513 samples a side. `between_samples`: see vertex_errors_m().
SurfaceTile prepare_surface_tile(const TileId& id, std::shared_ptr<const HeightTile> heights,
                                 double quantum_m, bool between_samples, const Ellipsoid& ellipsoid);

/// Returns the height in metres of the triangles between the samples; NaN where a sample that it needs is
/// void.
///
/// The diagonal of a cell rises to the north-east where its column and row are both even or both odd, as in
/// RqtSteps' hierarchy. Along an edge that tiles share, each of them gives the same height. A sample is
/// float(quanta)·float(quantum). REQUIRES: the point lies in the tile, edges included.
float height_at(const SurfaceTile& tile, const LatticePoint& point);

/// A tile's surface, shown with less detail than it has.
///
/// At a whole level it is the surface of the ancestor of the level: samples nest, so it is the tile's own
/// with only every 2nd, 4th, … row and column kept. Between two levels a height is that far between theirs.
struct ShownSurface {
  const SurfaceTile* tile = nullptr;  ///< null: height 0 everywhere
  double detail = 0;  ///< the tile's level or less, but not so little that no cell is left of it

  /// Returns the tile with so much detail as it can be shown with, `detail` at most.
  static ShownSurface of(const SurfaceTile* tile, double detail);
  /// The level whose heights are shown, mixed with those of the next coarser level by coarser_share().
  int finer_level() const;
  /// 0 up to but not including 1.
  float coarser_share() const;
};

/// A height that two levels have between them.
struct ShownHeight {
  float finer_m = 0;
  float to_coarser_m = 0;  ///< what the coarser level's height is above that; 0 where none is mixed in
  bool is_void = false;    ///< then the heights are of the void's filling

  float at(float coarser_share) const { return finer_m + to_coarser_m * coarser_share; }
};

/// Where a level's sample is void, the next finer level stands in. REQUIRES: there is a tile.
ShownHeight shown_height_at(const ShownSurface& surface, const LatticePoint& point);

/// Returns the shown height in metres; NaN for a void.
float height_at(const ShownSurface& surface, const LatticePoint& point);

}  // namespace cairn
