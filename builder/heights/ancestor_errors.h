#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "builder/heights/geometric_error.h"
#include "cairn/height_tile.h"

namespace cairn {

/// How far the surfaces of a tile's ancestors are, within the tile, from its posts and from its own samples.
/// The ancestor `up` levels above has every 2^up-th sample and is bilinear in between.
///
/// Found by branch and bound, as most places need not be looked at: over a cell where two surfaces are both
/// bilinear, they differ most at a corner; so nothing in the cell is farther from the coarser surface than it
/// can be from the finer one, plus the largest difference at the corners.
///
/// REQUIRES: no sample of the tile is void, all are within ±2^24 quanta. Tile and posts must outlive this.
class AncestorErrors {
 public:
  /// `own`: of the posts, measured against the tile itself.
  AncestorErrors(const HeightTile& tile, double quantum_m, std::span<const MeasuredPosts> posts,
                 const PostErrors& own);

  /// Whether a tile fulfils what is required of it.
  static bool can_measure(const HeightTile& tile);

  /// The largest distance from posts and samples, in metres. REQUIRES: 1 <= up, 2^up divides N-1.
  double max_m(int up) const;

  /// Whether a post is farther than this from the surface. REQUIRES: as max_m().
  bool any_post_beyond(int up, double limit_m) const;

 private:
  /// For an ancestor, what nothing in a cell of its surface exceeds. In quarters of a quantum, of which all
  /// deviations between neighbouring levels are multiples.
  struct Bounds {
    int cells = 0;  ///< a side
    std::vector<std::int32_t> of_cells;
    std::vector<std::int32_t> of_rows;  ///< the largest of each row of cells
    std::int32_t found = 0;  ///< the largest deviation of a sample midway between the surface's own

    std::int32_t at(int column, int row) const {
      return of_cells[static_cast<std::size_t>(row) * static_cast<std::size_t>(cells) +
                      static_cast<std::size_t>(column)];
    }
  };

  /// Posts by 2×2 group along an axis: those of group g are first[g] … first[g+1] - 1.
  struct LatticePosts {
    const MeasuredPosts* posts = nullptr;
    std::vector<std::uint32_t> first_column;
    std::vector<std::uint32_t> first_row;
  };

  /// Posts off any lattice, by 2×2 group: those of group g are order[first[g]] … order[first[g+1] - 1].
  struct PlacedPosts {
    const MeasuredPosts* posts = nullptr;
    std::vector<std::uint32_t> first;
    std::vector<std::uint32_t> order;
  };
  static PlacedPosts by_group(const MeasuredPosts& posts, int groups);

  struct Search;
  const Bounds& bounds(int up) const { return bounds_[static_cast<std::size_t>(up) - 1]; }

  const HeightTile& tile_;
  double quantum_m_;
  bool posts_are_exact_;  ///< so that no post is farther from an ancestor than the samples around it
  std::vector<LatticePosts> lattices_;
  std::vector<PlacedPosts> placed_;
  std::vector<Bounds> bounds_;  // [k]: level k+1
};

}  // namespace cairn
