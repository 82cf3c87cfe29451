#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "builder/heights/error_stats.h"
#include "builder/mosaic/sample_window.h"
#include "builder/mosaic/source_group.h"
#include "cairn/height_tile.h"

namespace cairn {

/// How far a tile's surface is from posts.
struct SurfaceError {
  double max_m = 0;        ///< over the posts where the surface is defined
  bool has_holes = false;  ///< a post lies where the surface is void
};

/// Measures the surface that a tile has at a coarser level against posts: every 2^`levels`-th sample, linear
/// in between (levels 0 is the tile itself). REQUIRES: 2^levels divides tile.size - 1.
SurfaceError measure_surface(const HeightTile& tile, double quantum_m, int levels,
                             const MeasuredPosts& posts);

/// The largest error of the posts in each 2×2 group of a tile's cells: metres, rows south to north. No
/// groups: every post's error is 0.
struct PostErrors {
  std::vector<float> groups;  ///< ((N-1)/2)², each rounded up

  /// In which of the groups along an axis a post lies.
  static int group_of(double at, int groups) { return std::min(static_cast<int>(at) / 2, groups - 1); }
};

/// Which of a tile's posts are the tile's to count, so that each post is counted once: those on its west and
/// south edges, and on the others where no tile lies beyond.
struct PostCounting {
  SampleWindow window;
  bool count_east = false;
  bool count_north = false;
  bool count_north_west = false;  ///< the corner alone
  bool count_north_east = false;  ///< the corner alone
  /// The window's column at 180°E, from which on posts are the tile's at 180°W.
  double antimeridian = HUGE_VAL;

  /// Where the surface measured is an ancestor's: its sample (x0, y0) is the window's corner, and one of its
  /// samples is `scale` of the window's.
  double x0 = 0;
  double y0 = 0;
  double scale = 1;

  bool counts(double surface_x, double surface_y) const {
    const double x = (surface_x - x0) * scale;
    const double y = (surface_y - y0) * scale;
    if (x > antimeridian || (x == antimeridian && !count_east)) return false;
    const bool east = x >= window.columns - 1;
    const bool north = y >= window.rows - 1;
    if (!east && !north) return true;
    if (east && north) return count_north_east;
    if (north && x <= 0) return count_north_west;
    return east ? count_east : count_north;
  }
  /// How many posts of a lattice are counted if all have heights.
  std::uint64_t count(const MeasuredPosts& posts) const;

  LonLat place(double surface_x, double surface_y) const {
    const double x = (surface_x - x0) * scale;
    const double y = (surface_y - y0) * scale;
    return {(static_cast<double>(window.column) + x) / window.samples_per_degree - 180.0,
            (static_cast<double>(window.row) + y) / window.samples_per_degree - 90.0};
  }
};

/// The same, every post's error also counted in `stats` if the post is this tile's to count.
SurfaceError measure_surface(const HeightTile& tile, double quantum_m, int levels, const MeasuredPosts& posts,
                             const PostCounting& counting, ErrorStats& stats);

/// Measures the tile itself, counts every post's error that is the tile's to count, and notes the errors by
/// group for AncestorErrors. `groups` starts without any.
SurfaceError measure_own_surface(const HeightTile& tile, double quantum_m, const MeasuredPosts& posts,
                                 const PostCounting& counting, ErrorStats& stats, PostErrors& errors);

}  // namespace cairn
