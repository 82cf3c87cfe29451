#pragma once

#include <span>

#include "builder/resample/post_smoothing.h"
#include "builder/resample/row_passes.h"
#include "builder/resample/smooth_axis.h"

namespace cairn {

/// The samples that a group of columns and a group of rows share, with the posts that bear on them. Nothing
/// outside is corrected by them, and nothing outside corrects them.
struct RunBlock {
  const SmoothAxis& x;
  const SmoothAxis& y;
  const SmoothAxis::Group& columns;
  const SmoothAxis::Group& rows;
};

/// Moves the block's samples towards the bounds of `smoothed`, with every post within the tolerance's
/// interval afterwards as before.
///
/// At most six rounds of alternating projections (Gubin, Polyak & Raik 1967), fewer where none overshoots by
/// more than the tolerance: samples onto their bounds, over-relaxed by half, then the surface onto the posts'
/// intervals by the least-norm correction. Bounds that no surface within the intervals keeps are exceeded by
/// a compromise. `posts` are those of x.posts × y.posts; heights begin at the block's south-western sample.
void keep_bounds(const RunBlock& block, const SmoothTolerance& tolerance, const SmoothedPosts& smoothed,
                 std::span<const float> posts, Rows<double> heights);

}  // namespace cairn
