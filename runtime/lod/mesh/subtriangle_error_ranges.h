#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/tile_id.h"

namespace cairn {

/// How far the larger flat triangles of a tile's bisection hierarchy are above their samples, part by part.
///
/// Lines parallel to the legs, a quarter of a leg apart, cut a triangle into ten parts: six squares and,
/// along its base, four triangles. With p the leg to the base's first corner and q the leg to its second,
/// part (i, j) has the places (i..i+1) p/4 + (j..j+1) q/4 from the right angle, i + j <= 3. Parts are
/// numbered along p first.
///
/// Worked out once when a tile is loaded, and immutable after that.
class SubtriangleErrorRanges {
 public:
  static constexpr int kSteps = 4;
  static constexpr std::size_t kParts = 10;
  /// Triangles have ranges if their span is at least so many cells. The span is that of the legs, or of the
  /// base where the base runs along the grid.
  static constexpr int kLeastSpan = 16;

  /// (column, row) of a sample of the tile.
  using Corner = std::array<int, 2>;
  /// The two corners of the base, then the right angle, anticlockwise.
  using Triangle = std::array<Corner, 3>;

  static constexpr int kMaxCode = std::numeric_limits<std::int16_t>::max();
  /// Returns a part's four corners in order; where the part is a triangle, the second one twice. REQUIRES:
  /// part < kParts.
  static std::array<Corner, 4> corners_of(const Triangle& triangle, std::size_t part);

  /// For each part of a triangle, the range of the triangle's height above the samples, negative where it is
  /// below them. In units of unit_m, rounded outwards. One cache line, with all that a test reads.
  struct alignas(64) Ranges {
    float unit_m = 0;
    std::array<std::int16_t, kParts> least{};
    std::array<std::int16_t, kParts> most{};
    std::array<std::int32_t, 3> quanta{};  ///< the samples at the triangle's corners

    /// Returns the largest absolute value of the ranges, in metres, to single precision.
    double largest_m() const { return static_cast<double>(unit_m) * kMaxCode; }
  };

  /// With `between_samples` the ranges hold for all places of the tile's bilinear surface, not for its
  /// samples alone.
  SubtriangleErrorRanges(const HeightTile& heights, const TileId& id, double quantum_m, bool between_samples);

  /// Returns the ranges of a triangle. REQUIRES: it belongs to the hierarchy, its span is at least
  /// kLeastSpan.
  const Ranges& of(const Triangle& triangle) const { return ranges_[slot(triangle)]; }

  std::uint64_t bytes() const { return ranges_.size() * sizeof(Ranges); }

 private:
  /// The two halves beside the diagonal, and the triangle at each edge.
  static constexpr std::size_t kTrianglesPerSquare = 6;

  /// Returns the index of square (k, x, y).
  std::size_t slot(int k, int x, int y) const {
    return first_[static_cast<std::size_t>(k)] + (static_cast<std::size_t>(y) << (levels_ - k)) +
           static_cast<std::size_t>(x);
  }
  std::size_t slot(const Triangle& triangle) const;

  int levels_;
  std::array<std::size_t, 16> first_{};  ///< the index of each level's first square
  std::vector<Ranges> ranges_;
};

}  // namespace cairn
