#pragma once

#include <cstdint>

namespace cairn {

/// One axis of a regular lattice of posts: post i, any integer, lies (i + phase)/posts_per_degree degrees
/// east of 180°W or north of 90°S. Rasters with equal axes share one numbering, so they can be mosaicked post
/// by post; numbers run on past 180°E.
struct LatticeAxis {
  double posts_per_degree = 1;  ///< > 0
  double phase = 0;             ///< 0 ≤ phase < 1

  friend bool operator==(const LatticeAxis&, const LatticeAxis&) = default;
};

/// A raster's columns or rows on their lattice.
struct LatticeSpan {
  LatticeAxis axis;
  std::int64_t first = 0;  ///< lattice index of the raster's westernmost column or southernmost row
};

/// The lattice of `count` posts that begin `first_degrees` from the axis's origin (180°W, 90°S) and lie
/// `spacing_degrees` > 0 apart. Files carry both as rounded decimals: a whole number of posts a degree is
/// taken where it moves no post by more than `most_drift` of a spacing, and a phase of 0 or 1/2 where that
/// moves them by no more than 1/10000.
LatticeSpan lattice_of(double first_degrees, double spacing_degrees, std::int64_t count, double most_drift);

}  // namespace cairn
