#pragma once

#include "builder/mosaic/mosaic.h"
#include "cairn/height_options.h"
#include "cairn/height_tile.h"

namespace cairn {

/// A mosaic tile in quanta, rounded to nearest.
struct QuantizedTile {
  HeightTile tile;
  double filled = 0;  ///< share of the samples that no source gave: filled or void
};

/// With VoidMode::keep filled samples are void, too.
QuantizedTile quantize_tile(const MosaicTile& mosaic, int tile_size, double quantum_m, VoidMode voids);

}  // namespace cairn
