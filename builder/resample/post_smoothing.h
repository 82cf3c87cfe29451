#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "builder/resample/row_passes.h"
#include "builder/resample/smooth_axis.h"
#include "builder/resample/smooth_tolerance.h"

namespace cairn {

/// What smooth resampling makes of the posts of a strip before it resamples them: rows of y.smoothed, south
/// to north, of the strip's columns of x.smoothed.
struct SmoothedPosts {
  IndexRange columns;
  Rows<float> heights;  ///< metres, without the posts' rounding noise
  Rows<float> lowest;   ///< metres: a sample in a cell stays above the least of its corners' …
  Rows<float> highest;  ///< … and below the greatest of these
};

/// Takes rounding noise off the posts and finds what overshoot they justify.
///
/// A height moves towards the quadratic fitted to the 5 × 5 posts around it (Savitzky & Golay 1964), most
/// where that is about two intervals away, and not at all from four intervals on: that is relief. Posts on
/// level ground, 3 × 3 posts of equal height, do not move, and justify no overshoot. Elsewhere a sample may
/// overshoot a post by half the smaller of the steps to its neighbours.
class PostSmoothing {
 public:
  /// `posts` are those of x.posts × y.posts; all that is passed outlives this.
  PostSmoothing(const SmoothAxis& x, const SmoothAxis& y, const SmoothTolerance& tolerance,
                std::span<const float> posts);

  /// Valid until the next call. REQUIRES: columns within x.smoothed.
  SmoothedPosts smooth(IndexRange columns);

 private:
  const float* post(std::int64_t i, std::int64_t j) const;
  void find_level();
  void mark_equal(Rows<std::uint8_t> equal) const;
  void spread_along_rows();
  void spread_across_rows();
  void smooth_row(std::int64_t j, float* heights);
  void bound_row(std::int64_t j, float* lowest, float* highest) const;

  const SmoothAxis& x_;
  const SmoothAxis& y_;
  SmoothTolerance tolerance_;
  std::span<const float> posts_;
  IndexRange columns_;  // the strip's
  IndexRange around_;   // and those that they depend on
  Scratch<float> heights_, lowest_, highest_;
  Scratch<std::uint8_t> equal_, unspread_, level_rows_;
  Rows<std::uint8_t> level_;    // by post of around_ × y.posts: 1 on level ground
  std::vector<double> change_;  // what smoothing adds to a row's posts
  std::vector<double> sums_;    // the row, smoothed across
};

}  // namespace cairn
