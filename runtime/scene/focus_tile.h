#pragma once

#include <optional>

#include "cairn/tile_id.h"
#include "cairn/view_state.h"

namespace cairn {

/// Returns the level, as a real number, whose samples are one pixel apart at this distance: the log2 of
/// (a degree of the equator / (tile_size - 1)) / pixel_footprint_m. Distances below a metre count as one.
double level_for_pixel_size(const ViewState& view, double distance_m, int tile_size);

/// Finds the camera's tile, with hysteresis while the camera hovers on a border.
///
/// The level is the first whose samples are at most a pixel apart, within the levels that exist. It is held
/// while the ideal level stays within `level_margin` of the interval that chose it, and the tile is held
/// while the eye stays within `tile_margin` tile widths of it. So:
/// - an eye that stays in a box of `tile_margin` tile widths and a band of `level_margin` levels (a factor of
///   2^level_margin in height above ground) changes its level once at most and its tile at most once besides,
///   however it moves in there;
/// - the eye is never more than `tile_margin` tile widths outside the tile that the map is built for.
/// Margins of 0 hold nothing.
class FocusTile {
 public:
  static constexpr double kTileMargin = 0.125, kLevelMargin = 0.25;  ///< those of TerrainOptions

  /// REQUIRES: 0 <= tile_margin < 1, 0 <= level_margin < 1.
  FocusTile(double tile_margin, double level_margin);

  /// REQUIRES: kMinLevel <= coarsest <= finest <= kMaxLevel.
  TileId update(LonLat eye, double ideal_level, int coarsest, int finest);

 private:
  int level_for(double ideal_level, int coarsest, int finest) const;
  bool holds(LonLat eye) const;

  double tile_margin_;
  double level_margin_;
  std::optional<TileId> held_;
};

}  // namespace cairn
