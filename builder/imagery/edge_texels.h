#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "builder/imagery/linear_image.h"
#include "format/bytes.h"
#include "cairn/status.h"

namespace cairn {

/// Texels on both sides of a tile's edges at every mip, so that neighbouring tiles can be given the same edge
/// texels: the mean of both sides. docs/imagery.md says why.
///
/// A mip's texel is 2^mip texels of the tile wide, but here it is never wider than kRim texels of the finest
/// tiles across the edge: no tile has to know more of its neighbours.
class EdgeTexels {
 public:
  static constexpr int kRim = 16;  ///< texels beyond a tile that cut() needs

  enum Side { north, east, south, west };

  EdgeTexels() = default;

  /// The rim of a finest tile. `padded` is the tile with kRim texels around it, `half` its halved().
  static EdgeTexels cut(const LinearImage& padded, const LinearImage& half);

  /// The rim of a tile from those of its children, by quadrant (bit 0 east, bit 1 north); null where there is
  /// none.
  static EdgeTexels join(const std::array<const EdgeTexels*, 4>& children, int size);

  /// Gives the texels along the edges of mip number `mip` the mean of both sides, and those in the corners
  /// that of four tiles. Where one side is empty nothing changes, nor at 1×1. REQUIRES: `image` has the
  /// tile's size at this mip.
  void agree(int mip, LinearImage& image) const;

  bool is_empty() const { return lines_.empty(); }
  void append_to(std::vector<std::byte>& out) const;
  static EdgeTexels read_from(ByteReader& in, int size);

 private:
  struct Pair {
    LinearTexel inside{};
    LinearTexel outside{};
  };
  /// The corner's own texel, and those of the neighbour east or west, north or south, and across.
  using Corner = std::array<LinearTexel, 4>;

  using Mips = std::vector<std::vector<Pair>>;  // by mip, each halved; from the west or from the north

  std::vector<Mips> lines_;                   // by Side
  std::vector<std::vector<Corner>> corners_;  // by quadrant, by mip; the last holds for all beyond
};

}  // namespace cairn
