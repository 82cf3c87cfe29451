#pragma once

#include <cstdint>
#include <span>

#include "builder/mosaic/mosaic.h"
#include "cairn/height_options.h"
#include "cairn/height_tile.h"

namespace cairn {

/// A mosaic tile in quanta, rounded to nearest.
struct QuantizedTile {
  HeightTile tile;
  double filled = 0;  ///< share of the samples that no source gave: filled or void
};

/// To what heights are rounded.
struct HeightSteps {
  double quantum_m = 0;
  int multiple = 1;  ///< in quanta, of samples that are not `single`
  /// By sample: 1 where it is rounded to one quantum. Empty: no sample is.
  std::span<const std::uint8_t> single = {};
};

/// With VoidMode::keep filled samples are void, too.
QuantizedTile quantize_tile(const MosaicTile& mosaic, int tile_size, const HeightSteps& steps,
                            VoidMode voids);

}  // namespace cairn
