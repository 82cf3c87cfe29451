#pragma once

#include "builder/resample/axis_weights.h"

namespace cairn {

/// Resamples one axis of a lattice of posts to samples at k/samples_per_degree degrees from the axis's
/// origin.
///
/// exact: post i falls into the sample interval j(i) at fraction t(i); row i of A holds (1-t, t) there. Of
/// all samples G with A·G = H (H the posts) it gives those nearest, in the sum of squares, to the cubic
/// interpolant G0: G = G0 + Aᵀ(AAᵀ)⁻¹(H - A·G0). Where samples are as dense as posts or denser, no interval
/// holds two posts and AAᵀ is tridiagonal; it falls apart into runs of posts in adjacent intervals, for an
/// empty interval parts two runs, and so does a post that lies on a sample and fixes it. So each sample
/// depends on the posts of one run and two beyond it on each side, and its weights on nothing but the axis,
/// the density and k: any two windows give the same bits. docs/resampling.md has the proof and the
/// measurements.
class AxisResampler {
 public:
  /// REQUIRES: samples_per_degree > 0. A post within 1e-6 of a sample, in sample spacings, lies on it.
  AxisResampler(LatticeAxis axis, double samples_per_degree, ResampleMethod method);

  /// Posts in the longest run: the exact method's cost a sample, and a measure of its conditioning. 0 where
  /// every post lies on a sample; INT64_MAX where runs have no end, or an interval can hold two posts.
  std::int64_t longest_run() const;

  /// Whether the method can be used: always, but for exact and smooth only where no run is longer than 32
  /// posts, that is from 1.032 samples a post, or with every post on a sample. Otherwise choose the next
  /// finer level.
  bool is_well_conditioned() const;

  /// The posts that these samples depend on. REQUIRES: is_well_conditioned(), samples not empty.
  IndexRange posts_for(IndexRange samples) const;

  /// REQUIRES: is_well_conditioned(), samples not empty.
  AxisWeights weights_for(IndexRange samples) const;

 private:
  IndexRange posts_at(std::int64_t sample) const;

  AxisPositions positions_;
  ResampleMethod method_;
};

}  // namespace cairn
