#pragma once

#include <span>

#include "builder/raster/georeference.h"
#include "builder/resample/index_window.h"
#include "builder/resample/post_fit.h"

namespace cairn {

/// Resamples a raster on a projected grid to samples at k/samples_per_degree degrees east of 180°W and north
/// of 90°S. The samples' bilinear surface passes, within a tolerance, through every post: cubic interpolation
/// (Keys 1981) in the raster's own grid, then the least change that fits the posts (post_fit.h).
///
/// Windows of posts have the raster's columns for x and its rows, in the file's order, for y; they may reach
/// beyond the raster, as filled voids do. Posts in squares that leave the sample window are not fitted, so
/// windows are to be computed with kHalo more samples on each side than are kept: then two windows differ by
/// no more than about the tolerance, and a surface put together from them keeps it. docs/resampling.md has
/// the measurements.
class ProjectedResampler {
 public:
  /// REQUIRES: samples_per_degree > 0.
  ProjectedResampler(const Georeference& georeference, double samples_per_degree);

  static constexpr std::int64_t kHalo = 16;

  /// Whether every window of the raster's posts can be fitted: from 1.03 samples a post, as
  /// posts_per_degree() counts. Otherwise choose the next finer level.
  bool is_well_conditioned(IndexWindow posts) const;

  /// The posts that these samples are made from.
  IndexWindow posts_for(IndexWindow samples) const;

  /// `heights` of posts_for(samples), none NaN. `out`: rows south to north, metres. Single precision holds a
  /// tolerance of 0.001 m at heights up to 9000 m.
  PostEquations::Fit resample(std::span<const float> heights, IndexWindow samples, double tolerance_m,
                              std::span<float> out) const;

 private:
  LonLat place_of_sample(double x, double y) const;
  void interpolate(IndexWindow posts, std::span<const float> heights, IndexWindow samples,
                   std::span<float> out) const;
  PostEquations equations(IndexWindow posts, std::span<const float> heights, IndexWindow samples) const;

  Georeference georeference_;
  double samples_per_degree_;
};

/// The samples a degree from which on no square of samples holds two posts of these, so that a surface
/// through all can exist: the reciprocal of the shortest step between neighbouring posts, longitude and
/// latitude taken apart and the longer of both counting.
double posts_per_degree(const Georeference& georeference, IndexWindow posts);

}  // namespace cairn
