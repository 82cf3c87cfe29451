#pragma once

#include <cstdint>

#include "builder/resample/index_window.h"
#include "builder/resample/lattice_axis.h"

namespace cairn {

/// Where the posts of an axis lie among its samples, sample k being k/samples_per_degree degrees from the
/// axis's origin. A post within 1e-6 sample spacings of a sample lies on it.
class AxisPositions {
 public:
  /// REQUIRES: samples_per_degree > 0.
  AxisPositions(LatticeAxis axis, double samples_per_degree);

  /// Samples a post.
  double ratio() const { return ratio_; }
  /// The post's place in sample spacings, a whole number where it lies on a sample.
  double position(std::int64_t post) const;
  /// The sample at or before the post, and how far past it the post lies: 0 ≤ fraction < 1.
  std::int64_t interval_of(std::int64_t post) const;
  double fraction_of(std::int64_t post) const;

  /// The sample's place in post indices.
  double post_coordinate(std::int64_t sample) const;
  /// The first post at the sample or beyond.
  std::int64_t first_post_from(std::int64_t sample) const;
  bool is_on_post(std::int64_t sample) const;

  /// Whether no post lies off the samples.
  bool all_posts_on_samples() const;

 private:
  LatticeAxis axis_;
  double ratio_;
};

}  // namespace cairn
