#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "builder/resample/index_window.h"

namespace cairn {

/// What a raster's voids are filled from, far from their rims: a complete grid of mean heights at 1/32 of the
/// posts' resolution, cell c of it standing for posts 32c … 32c+31 along each axis. Immutable.
class FillPyramid {
 public:
  static constexpr int kLevel = 5;  ///< log2 of the posts along a cell's side

  /// No post of the raster is valid: there is nothing to fill from.
  bool empty() const { return heights_.empty(); }

  /// The height of a cell; beyond the raster that of the nearest cell in it. REQUIRES: not empty.
  float at(std::int64_t x, std::int64_t y) const;

 private:
  friend class FillPyramidBuilder;
  IndexWindow cells_;
  std::vector<float> heights_;
};

/// Makes a FillPyramid from one pass over the posts, in blocks of any shape and order: the sums are exact, so
/// the result is the same bits. Takes 12 bytes for each 1024 posts of the raster.
class FillPyramidBuilder {
 public:
  /// `posts`: the raster's extent on its lattice. REQUIRES: not empty.
  explicit FillPyramidBuilder(IndexWindow posts);

  /// Heights in metres, NaN where void; beyond ±2^20 m they count as that. Each post once. From one thread at
  /// a time. REQUIRES: the window lies in the raster.
  void add(IndexWindow window, std::span<const float> heights);

  std::int64_t valid_posts() const { return valid_posts_; }

  /// Cells with valid posts get their mean; the others are filled as fill_voids() fills posts, in a pyramid
  /// that ends in one cell for the whole raster.
  FillPyramid complete() const;

 private:
  IndexWindow cells_;
  std::vector<std::int64_t> sums_;  // of heights in 2^-16 m
  std::vector<std::int32_t> counts_;
  std::int64_t valid_posts_ = 0;
};

}  // namespace cairn
