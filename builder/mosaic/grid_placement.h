#pragma once

#include <cstdint>
#include <optional>

#include "builder/raster/georeference.h"
#include "builder/raster/raster_source.h"

namespace cairn {

/// A raster's place on a grid: its first post is the grid's post (column, row).
struct GridPlacement {
  std::int64_t column = 0;
  std::int64_t row = 0;
  bool is_shifted = false;  ///< its posts lie a little off the grid's: by more than 1e-6 of a post
};

/// The place of a raster on the grid of posts that `grid` extends over its CRS's plane; nullopt where the CRS
/// is another, or where its posts are off the grid's by more than a hundredth of a post.
std::optional<GridPlacement> place_on_grid(const RasterInfo& info, const Georeference& grid);

}  // namespace cairn
