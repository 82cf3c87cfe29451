#pragma once

#include <span>

#include "builder/resample/post_smoothing.h"
#include "builder/resample/smooth_axis.h"

namespace cairn {

/// Posts → samples whose bilinear surface is within an interval of every post, and as smooth as that allows.
///
/// Rounding noise is taken off the posts (post_smoothing.h), they are interpolated by the bicubic, and what
/// that misses a post by beyond the interval is made up for by the least-norm correction of AxisResampler,
/// along both axes. Where a sample then overshoots beyond the tolerance, the samples that are corrected
/// together are moved towards their bounds (run_block.h). At every post the surface is within interval_m, but
/// for the rounding of its samples to float: 0.0006 m at 9000 m. docs/resampling.md has the measurements.
///
/// `posts` and `out` are row-major, rows south to north, in metres. A sample depends on the posts that
/// SmoothAxis names for its own column and row and on nothing else, bit for bit; a sample on the line of a
/// post on the posts of that line alone. REQUIRES: the post window is x.posts × y.posts for the sample
/// window's axes; no post is NaN.
void smooth_lattice(const SmoothAxis& x, const SmoothAxis& y, const SmoothTolerance& tolerance,
                    std::span<const float> posts, IndexWindow sample_window, std::span<float> out);

}  // namespace cairn
