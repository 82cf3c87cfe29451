#pragma once

#include <cstdint>
#include <span>

namespace cairn::bench {

/// An endless synthetic relief on the lattice of `posts_per_degree` posts a degree: sea, plains, hills,
/// ranges with crests. A height is a function of the seed and of the post's own lattice place alone, so
/// windows that overlap agree to the last bit, whatever their shape and order.
///
/// Octaves of hashed lattice values are refined by cubic B-spline subdivision (weights 1 6 1 / 8 on old
/// posts, 4 4 / 8 between), each octave weaker by 2^-H as in fractional Brownian motion; where the land is
/// rough comes from a field of its own, as in Musgrave's heterogeneous terrain (Musgrave, Kolb & Mace 1989).
class SyntheticRelief {
 public:
  SyntheticRelief(int posts_per_degree, std::uint32_t seed);

  /// Whole metres of the posts (x + i, y + j), i < columns and j < rows, row-major, rows from SOUTH to north;
  /// x counts posts east of Greenwich, y north of the equator. out.size() = columns·rows.
  void heights(std::int64_t x, std::int64_t y, int columns, int rows, std::span<std::int16_t> out) const;

 private:
  int posts_per_degree_;
  int top_octave_;
  std::uint32_t seed_;
};

}  // namespace cairn::bench
