#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cairn/tile_id.h"

namespace cairn {

/// Returns whether the diagonal of the square of s cells at (column, row) runs from south-west to north-east.
/// `rising` says so of the tile's own square. REQUIRES: s divides column and row.
inline bool diagonal_rises(bool rising, int size, int column, int row, int s) {
  return s == size - 1 ? rising : ((column / s ^ row / s) & 1) == 0;
}

/// Returns `rising` of a tile's own square. It is that of the quarter of its parent's square that the tile
/// is, so that the triangulations of all levels are one hierarchy.
inline bool root_rises(const TileId& id) {
  return ((id.x ^ id.y) & 1) == 0;
}

/// Restricted quadtree triangulations of a tile (Pajarola 1998; Intel 2012), each coarser than the one before
/// and part of it. For each vertex the number of triangulations that have it is stored.
///
/// A triangulation consists of right triangles. Each is bisected at the middle of its hypotenuse, its base
/// vertex, if that vertex is enabled. A square of s cells (s = N-1, (N-1)/2, … 2) has its centre, the base of
/// two halves of the square, and the middles of its four edges, each the base of a quarter and of the quarter
/// beyond the edge. A middle depends on the centres of the squares on both sides of its edge (of one square
/// on the tile's border); a centre on those two corners of its square that are not on its diagonal. The
/// tile's corners are always vertices.
class RqtSteps {
 public:
  /// Has no vertex but the corners. REQUIRES: size = 2^n + 1, 3 to 4097.
  RqtSteps(int size, bool rising);

  int size() const { return size_; }
  bool rising() const { return rising_; }
  int at(int column, int row) const { return steps_[index(column, row)]; }
  /// Returns whether triangulation k has the vertex; 0 is the finest.
  bool has(int column, int row, int k) const { return at(column, row) > k; }
  std::span<const std::uint8_t> all() const { return steps_; }  ///< row-major from the south-west
  std::span<std::uint8_t> writable() { return steps_; }         ///< likewise; REQUIRES what set() does

  /// Adds the vertex, and all that it depends on within the tile, to the first `steps` triangulations.
  void raise(int column, int row, int steps);
  /// Sets the vertex alone. REQUIRES: what it depends on is set before the triangulations are read.
  void set(int column, int row, int steps) { steps_[index(column, row)] = static_cast<std::uint8_t>(steps); }

  /// Returns the number of triangles of triangulation k.
  std::size_t triangle_count(int k) const;

  friend bool operator==(const RqtSteps&, const RqtSteps&) = default;

 private:
  std::size_t index(int column, int row) const {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(size_) + static_cast<std::size_t>(column);
  }
  int size_;
  bool rising_;
  std::vector<std::uint8_t> steps_;
};

inline constexpr int kMostRqtSteps = 16;

/// The two vertices that another depends on, as indices into all().
struct RqtNeeds {
  std::size_t first;
  std::size_t second;  ///< equal to the first on the tile's border
};

/// Returns what a vertex depends on. REQUIRES: it is no corner of the tile.
RqtNeeds rqt_needs_of(int column, int row, int size, bool rising);

/// Calls visit(index, needs) for every vertex but the corners, from the coarsest square to the finest,
/// centres before middles, row by row from the south: each comes after those that it depends on.
template <class Visit>
void for_each_rqt_vertex(int size, bool rising, const Visit& visit) {
  const int last = size - 1;
  const auto at = [size](int c, int r) {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(size) + static_cast<std::size_t>(c);
  };
  for (int s = last; s >= 2; s /= 2) {
    const int h = s / 2;
    for (int r = h; r < last; r += s) {
      for (int c = h; c < last; c += s) {
        const bool rises = diagonal_rises(rising, size, c - h, r - h, s);
        visit(at(c, r), rises ? RqtNeeds{at(c + h, r - h), at(c - h, r + h)}
                              : RqtNeeds{at(c - h, r - h), at(c + h, r + h)});
      }
    }
    for (int r = 0; r <= last; r += h) {
      if (r / h % 2 == 0) {
        for (int c = h; c < last; c += s)
          visit(at(c, r), RqtNeeds{at(c, r == 0 ? h : r - h), at(c, r == last ? r - h : r + h)});
      } else {
        for (int c = 0; c <= last; c += s)
          visit(at(c, r), RqtNeeds{at(c == 0 ? h : c - h, r), at(c == last ? c - h : c + h, r)});
      }
    }
  }
}

}  // namespace cairn
