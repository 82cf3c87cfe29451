#pragma once

#include <cstdint>

#include "builder/export/geodesy.h"
#include "builder/export/metre_tiles.h"
#include "builder/export/pack_patches.h"
#include "cairn/status.h"

namespace cairn {

/// The pack's height at a place, metres, bilinear in the finest tile up to this level that has the place; NaN
/// where there is none or the place is void.
Result<double> pack_height(const PackPatches& patches, MetreTiles& tiles, std::int64_t x, std::int64_t y,
                           int finest);

/// The surface at a place.
struct SurfacePoint {
  Vector3 normal{};  ///< geocentric unit vector
  bool has_height = false;
};

/// The surface's normal by differences of the finest samples around the place: the same for every tile that
/// has the place. Straight up at the poles and where the pack has no height.
Result<SurfacePoint> surface_normal(const PackPatches& patches, MetreTiles& tiles, std::int64_t x,
                                    std::int64_t y);

}  // namespace cairn
