#pragma once

#include <functional>
#include <span>
#include <vector>

#include "builder/raster/georeference.h"
#include "builder/resample/index_window.h"
#include "builder/resample/post_fit.h"
#include "builder/resample/projection_mesh.h"

namespace cairn {

/// Where a window's samples lie among the posts.
struct SamplePositions {
  IndexWindow samples;
  std::vector<PlanePoint> at;  ///< by sample: column and row of posts; NaN out of the posts' reach
  IndexWindow posts;           ///< that the samples are interpolated from; empty where none is in reach
  bool all_in_reach = true;
};

/// Resamples posts on a grid in any CRS to samples at k/samples_per_degree degrees east of 180°W and north of
/// 90°S. The samples' bilinear surface passes, within a tolerance, through every post: cubic interpolation
/// (Keys 1981) in the posts' own grid, then the least change that fits the posts (post_fit.h).
///
/// Windows of posts have the grid's columns for x and its rows, in the grid's order, for y. Posts in squares
/// that leave the sample window are not fitted, so windows are to be computed with kHalo more samples on each
/// side than are kept: then two windows differ by no more than about the tolerance, and a surface put
/// together from them keeps it. Longitudes are compared around the Earth, so windows and posts may lie on
/// both sides of 180°. docs/resampling.md has the measurements.
class ProjectedResampler {
 public:
  /// `extent`: of the posts that there are. REQUIRES: samples_per_degree > 0.
  ProjectedResampler(const Georeference& georeference, IndexWindow extent, double samples_per_degree);

  static constexpr std::int64_t kHalo = 16;

  /// Whether every window of the posts can be fitted: from 1.03 samples a post, as posts_per_degree()
  /// counts. Otherwise choose the next finer level.
  bool is_well_conditioned() const;

  /// Samples within four posts of the extent are in reach.
  SamplePositions positions_of(IndexWindow samples) const;

  /// All posts whose places lie in the closed window of samples, and some around them; empty where there are
  /// none.
  IndexWindow posts_near(IndexWindow samples) const;

  using VisitPlaces = std::function<void(std::int64_t row, std::span<const PlanePoint> places)>;
  /// Calls `visit` with the places of the posts, row by row, in samples, on that side of 180° that is nearer
  /// to the samples' middle; not finite where the CRS has no place, and for posts that are well outside of
  /// the window of samples. `shifts`: by post, by how much of a post it lies off the grid, at most a
  /// hundredth; empty where none does.
  void visit_places(IndexWindow posts, IndexWindow samples, std::span<const PlanePoint> shifts,
                    const VisitPlaces& visit) const;

  /// `heights` of positions.posts, none NaN; `fitted`: which of them the surface has to meet (0 or 1).
  /// `shifts`: see visit_places(). `out`: rows south to north, metres, NaN out of reach. `met`, unless empty:
  /// becomes 1 for each sample of a square that holds a fitted post. Single precision holds a tolerance of
  /// 0.001 m at heights up to 9000 m.
  PostEquations::Fit resample(std::span<const float> heights, std::span<const std::uint8_t> fitted,
                              std::span<const PlanePoint> shifts, const SamplePositions& positions,
                              const FitTolerance& tolerance, std::span<float> out,
                              std::span<std::uint8_t> met) const;

  /// Samples around the Earth.
  double around() const { return 360 * samples_per_degree_; }

 private:
  PlanePoint position_of(std::int64_t x, std::int64_t y) const;
  bool is_in_reach(const PlanePoint& position) const;
  ProjectionMesh::Box around_window(IndexWindow samples) const;
  void interpolate(std::span<const float> heights, const SamplePositions& positions,
                   std::span<float> out) const;
  PostEquations equations(std::span<const float> heights, std::span<const std::uint8_t> fitted,
                          std::span<const PlanePoint> shifts, const SamplePositions& positions,
                          std::span<std::uint8_t> met) const;

  Georeference georeference_;
  IndexWindow extent_;
  double samples_per_degree_;
  double middle_lon_;
};

/// The samples a degree from which on no square of samples holds two posts of these, so that a surface
/// through all can exist: the reciprocal of the shortest step between neighbouring posts, longitude and
/// latitude taken apart and the longer of both counting.
double posts_per_degree(const Georeference& georeference, IndexWindow posts);

}  // namespace cairn
