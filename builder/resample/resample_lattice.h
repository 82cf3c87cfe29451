#pragma once

#include <span>

#include "builder/resample/axis_resampler.h"

namespace cairn {

/// Posts → samples, one axis after the other: since A·G·Aᵀ = H separates, so does exactness, and the bilinear
/// surface of the samples passes through every post.
///
/// `posts` and `out` are row-major, rows south to north, of heights in metres. The sums are made in double
/// and rounded once, to float; at 9000 m the exact method misses a post by less than 0.0006 m. A sample
/// depends on the posts that posts_for() of its own column and row names, and on nothing else, bit for bit.
/// REQUIRES: both axes are well conditioned; the post window holds posts_for() of the sample window; no post
/// is NaN.
void resample_lattice(const AxisResampler& x, const AxisResampler& y, IndexWindow post_window,
                      std::span<const float> posts, IndexWindow sample_window, std::span<float> out);

}  // namespace cairn
