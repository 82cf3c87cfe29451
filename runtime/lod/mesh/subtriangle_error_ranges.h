#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/tile_id.h"

namespace cairn {

/// Where the samples of a tile are below and above the larger flat triangles of its bisection hierarchy, part
/// by part.
///
/// Four lines along each leg, a quarter of it apart, cut a triangle into six squares and four triangles at
/// its base. With p the leg to the base's first corner and q that to its second, part (i, j) has the places
/// (i..i+1) p/4 + (j..j+1) q/4 from the right angle, i + j <= 3; parts are numbered along p first.
class SubtriangleErrorRanges {
 public:
  static constexpr int kSteps = 4;
  static constexpr std::size_t kParts = 10;
  /// Triangles with ranges: legs, or the base where that runs along the grid, of so many cells.
  static constexpr int kLeastSpan = 16;

  /// (column, row) of the tile's samples.
  using Corner = std::array<int, 2>;
  /// The base's two corners, then the right angle: anticlockwise.
  using Triangle = std::array<Corner, 3>;

  static constexpr int kCodes = std::numeric_limits<std::int16_t>::max();
  /// A part's corners, in order; a triangle's second is there twice. REQUIRES: part < kParts.
  static std::array<Corner, 4> corners_of(const Triangle& triangle, std::size_t part);

  /// Of a triangle: how far it is above its parts' samples, at least and at most; below, where negative. In
  /// units, rounded outwards.
  struct alignas(64) Ranges {
    float unit_m = 0;
    std::array<std::int16_t, kParts> least{};
    std::array<std::int16_t, kParts> most{};
    std::array<std::int32_t, 3>
        quanta{};  ///< the samples at its corners: what a look needs is one cache line

    /// No absolute value is larger; one is that large, to single precision.
    double most_m() const { return static_cast<double>(unit_m) * kCodes; }
  };

  /// `between_samples`: all places of the tile's bilinear surface count, not its samples alone.
  SubtriangleErrorRanges(const HeightTile& heights, const TileId& id, double quantum_m, bool between_samples);

  /// REQUIRES: a triangle of the hierarchy, of kLeastSpan or more.
  const Ranges& of(const Triangle& triangle) const { return ranges_[slot(triangle)]; }

  std::uint64_t bytes() const { return ranges_.size() * sizeof(Ranges); }

 private:
  static constexpr std::size_t kOfSquare = 6;  ///< the halves by the diagonal, a triangle at each edge

  /// Of a square, in squares.
  std::size_t slot(int k, int x, int y) const {
    return first_[static_cast<std::size_t>(k)] + (static_cast<std::size_t>(y) << (levels_ - k)) +
           static_cast<std::size_t>(x);
  }
  std::size_t slot(const Triangle& triangle) const;

  int levels_;
  std::array<std::size_t, 16> first_{};  ///< of each level's squares
  std::vector<Ranges> ranges_;
};

}  // namespace cairn
