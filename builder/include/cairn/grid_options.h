#pragma once

#include <optional>

#include "cairn/geo.h"

namespace cairn {

/// Which tiles a pack has, whatever is on them.
struct GridOptions {
  int tile_size = 513;              ///< samples along a tile's side: 513 or 257; texture tiles have one less
  std::optional<int> top;           ///< the coarsest level; by default 0, or kMinLevel for a global input
  std::optional<GeoBounds> region;  ///< only tiles that touch it
};

}  // namespace cairn
