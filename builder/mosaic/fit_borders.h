#pragma once

#include <span>

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
/// but itself and its halo. `intervals`: of each of `samples.posts`, metres. A post stays as it is where the
/// surface is within its interval; others are brought to twice `tolerance_m` inside it, or met where it is
/// narrower. Blocks without such a line, and those all of whose posts are within their intervals, stay as
/// they are; so do samples farther than kFitReach from the line, and those in the halo of `window`. What
/// changes counts as touched. REQUIRES: `window` is a fit_window().
void fit_borders(const SampleWindow& window, OverlaidSamples& samples, double tolerance_m,
                 std::span<const double> intervals);

}  // namespace cairn
