#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "builder/raster/raster_source.h"
#include "cairn/geo.h"
#include "cairn/status.h"

namespace cairn {

/// A place of a raster at which something is odd.
struct OddPlace {
  std::int64_t column = 0;
  std::int64_t row = 0;
  LonLat place;
  double metres = 0;  ///< by how much it is
};

/// A line between two columns or two rows at which all heights jump.
struct HeightStep {
  bool between_columns = false;
  std::int64_t before = 0;  ///< the column or row before the line
  double metres = 0;        ///< the mean jump, beyond what the slopes on both sides account for
};

/// What the posts of a raster of heights show.
struct RasterFindings {
  std::uint64_t posts = 0;
  std::uint64_t voids = 0;
  double lowest_m = 0;  ///< 0 where all posts are void
  double highest_m = 0;
  bool only_whole_metres = true;
  std::uint64_t level_posts = 0;  ///< that have the height of both neighbours to the east and the south
  double level_m = 0;             ///< the height that most of these have
  std::uint64_t spikes = 0;       ///< posts that stand out from all four neighbours
  std::vector<OddPlace> highest_spikes;  ///< at most ten, the highest first
  std::vector<HeightStep> steps;         ///< at most ten, the highest first
};

/// Reads every post once, in bands of rows. A spike is a post above or below its four neighbours by more than
/// 20 m and by more than five times what 99 % of the posts differ from their neighbours' mean. A step is a
/// line across the whole raster whose mean jump is more than 0.5 m and more than ten times the median of all
/// lines'.
Result<RasterFindings> inspect_raster(const RasterSource& source);

/// What two rasters that touch or overlap have at the posts of their common line.
struct Seam {
  std::uint64_t posts = 0;  ///< that both have
  double mean_m = 0;        ///< of the second above the first
  double max_m = 0;         ///< of the absolute differences
};

/// Compares the posts that two lat/long rasters of one grid have in common; no posts where they have none, or
/// lie on different grids.
Result<Seam> compare_rasters(const RasterSource& first, const RasterSource& second);

}  // namespace cairn
