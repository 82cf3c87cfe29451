#pragma once

#include <functional>

#include "builder/export/height_samples.h"
#include "builder/export/metre_tiles.h"
#include "builder/export/pack_patches.h"
#include "builder/export/vertical_shift.h"
#include "cairn/status.h"

namespace cairn {

/// The ground of a region as one grid.
struct RegionRaster {
  TickRect rect;          ///< of the samples: the region, widened to the next samples
  std::int64_t step = 1;  ///< ticks from one sample to the next
  int level = 0;          ///< of the pack's tiles that have this step
  /// kUnitsOfStep from one sample to the next, from (0, 0) on. Voids have no height that means one.
  HeightSamples samples;
  bool has_voids = false;
  double lowest_m = 0;
  double highest_m = 0;

  LonLat place(double column, double row) const;
};
inline constexpr std::int64_t kUnitsOfStep = 64;

/// What a void's height is: so low that no triangle from one to the ground is near the ground.
inline constexpr float kVoidHeight = -1e9F;

/// Reads the region from tiles with at most this error, at the step of the finest of them, and adds the
/// shift. The samples' error says how far the ground is off their bilinear surface. usage where they are
/// more than `most_samples`, failed where the pack has no height there or `go_on` returns false.
Result<RegionRaster> region_raster(const PackReader& pack, const PackPatches& patches, MetreTiles& tiles,
                                   const VerticalShift& shift, const TickRect& region, double error_m,
                                   std::size_t most_samples, const std::function<Status()>& go_on);

}  // namespace cairn
