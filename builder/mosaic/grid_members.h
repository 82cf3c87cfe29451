#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "builder/raster/georeference.h"
#include "builder/raster/raster_source.h"
#include "builder/resample/index_window.h"

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

/// Which of many rectangles of a grid reach into a window.
class GridMembers {
 public:
  explicit GridMembers(std::vector<IndexWindow> extents);

  const std::vector<IndexWindow>& extents() const { return extents_; }
  /// The smallest window around all.
  IndexWindow hull() const { return hull_; }
  /// Their numbers, ascending.
  std::vector<std::size_t> overlapping(const IndexWindow& window) const;

 private:
  IndexWindow cells_of(const IndexWindow& window) const;

  std::vector<IndexWindow> extents_;
  IndexWindow hull_;
  std::int64_t cell_ = 1;  // posts along the side of a cell
  std::unordered_map<std::int64_t, std::vector<std::uint32_t>> by_cell_;
};

}  // namespace cairn
