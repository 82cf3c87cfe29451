#pragma once

#include <cstdint>
#include <vector>

#include "builder/export/height_samples.h"
#include "builder/export/quantized_mesh_source.h"
#include "cairn/status.h"

namespace cairn {

/// The finest samples where a coarser lattice of the pack has no surface: in its cells that have a void
/// corner source posts may lie all the same.
struct RimGrids {
  std::int64_t finest_step = 1;  ///< ticks: the least of the grids' and of what it was
  /// In ticks from the south-west of the tile of the export; NaN where the lattice has a surface.
  std::vector<HeightSamples> grids;
};

/// Adds the rim of one patch, whose samples are looked at every `step` ticks, within a tile of the export.
/// `wanted_m` is the error that the patch may have: where its ground is no farther from 0
/// than that, no grid is added and the heights' spread is returned, which no post there is farther off than.
Result<double> add_rim(const QuantizedMeshSource& source, const GeographicTile& tile, const Patch& patch,
                       std::int64_t step, double wanted_m, RimGrids& out);

/// Gives each void sample beside ground the mean of the samples around it that have a height, so that a
/// surface goes on beyond the rim of the ground. Such samples stay voids. Samples without a neighbour that
/// has a height get `beyond`.
void extend_ground(HeightSamples& grid, float beyond);

}  // namespace cairn
