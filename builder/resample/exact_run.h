#pragma once

#include <optional>
#include <vector>

#include "builder/resample/axis_weights.h"

namespace cairn {

/// Posts of adjacent sample intervals, none of them on a sample, as many as there are in a row.
struct PostRun {
  IndexRange posts;
  IndexRange samples;  ///< the samples that they bear on, less those at the ends that a post lies on
};

/// The run that bears on the sample, if any. REQUIRES: the sample is not on a post.
std::optional<PostRun> run_at(const AxisPositions& axis, std::int64_t sample);

/// The posts that the run's samples depend on.
IndexRange posts_under(const AxisPositions& axis, const PostRun& run);

/// Appends the weights of the run's samples from `first` to `last`; AxisResampler has the formula.
/// REQUIRES: both within run.samples.
void append_exact_rows(const AxisPositions& axis, const PostRun& run, IndexRange samples, AxisWeights& to);

/// Appends the weights by which all samples of the run take up what is missing at its posts, Aᵀ(AAᵀ)⁻¹ in the
/// notation of AxisResampler: a row of run.posts for each of run.samples. REQUIRES: no post of the run
/// touches a sample that another post lies on, as it is from one sample per post on.
void append_correction_rows(const AxisPositions& axis, const PostRun& run, AxisWeights& to);

}  // namespace cairn
