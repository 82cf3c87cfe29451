#pragma once

#include <optional>
#include <span>

#include "builder/heights/ancestor_errors.h"
#include "builder/heights/error_stats.h"
#include "builder/heights/geometric_error.h"
#include "cairn/height_tile.h"

namespace cairn {

/// Measures the surfaces that a leaf has at its own level and at those above it, against the posts that won
/// there and against its samples.
class LeafErrors {
 public:
  /// REQUIRES: tile and posts outlive this.
  LeafErrors(const HeightTile& tile, double quantum_m, std::span<const MeasuredPosts> posts,
             const PostCounting& counting);

  /// Of the leaf itself, against the posts.
  const SurfaceError& own() const { return own_; }
  const ErrorStats& own_stats() const { return own_stats_; }

  /// How far the surface `up` levels above is from the posts and from the leaf's samples: what the scene sees
  /// of a coarser tile is its distance from the finest, between the posts too.
  double max_m(int up) const;

  /// Whether that surface keeps an error bound to the posts; `max_m` is max_m(up).
  bool keeps(int up, double error_bound_m, double max_m) const;

  /// Every counted post's error there; `max_m` is max_m(up).
  ErrorStats stats(int up, double max_m) const;

 private:
  SurfaceError of_posts(int up) const;
  MeasuredPosts samples_as_posts() const;

  const HeightTile& tile_;
  double quantum_m_;
  std::span<const MeasuredPosts> posts_;
  PostCounting counting_;
  SurfaceError own_;
  ErrorStats own_stats_;
  PostErrors own_errors_;
  std::optional<AncestorErrors> ancestors_;  ///< unset where only each post by itself can be measured
};

}  // namespace cairn
