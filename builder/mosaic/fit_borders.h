#pragma once

#include "builder/mosaic/overlaid_samples.h"

namespace cairn {

/// Samples from the line between two groups up to which a fit changes any.
inline constexpr int kFitReach = 16;

/// Samples along a block's side.
inline constexpr int kFitBlock = 32;

/// The samples that a fit of this window makes and looks at: whole blocks of the world's sample grid, and a
/// halo around them.
SampleWindow fit_window(const SampleWindow& window);

/// Near the line where one group ends and another begins, brings the surface to the posts that won on both
/// sides, by the least change of the samples, in blocks of the world's grid, each of which depends on nothing
/// but itself and its halo. Blocks without such a line, and those all of whose posts are within
/// `allowance_m`, stay as they are; so do samples farther than kFitReach from the line, and those in the halo
/// of `window`. What changes counts as touched. REQUIRES: `window` is a fit_window().
void fit_borders(const SampleWindow& window, OverlaidSamples& samples, double tolerance_m,
                 double allowance_m);

}  // namespace cairn
