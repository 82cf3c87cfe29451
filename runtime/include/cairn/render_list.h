#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "cairn/bounding_volume.h"
#include "cairn/loaded_tile.h"
#include "cairn/status.h"

namespace cairn {

/// One area to draw, and its data. Where the data is a coarser tile's, the area is a window of it.
struct RenderTile {
  TileId area;
  TileId heights_id;                           ///< the area or an ancestor
  std::shared_ptr<const HeightTile> heights;   ///< null where the pack has no heights: draw nothing
  TileId imagery_id;                           ///< the area or an ancestor
  std::shared_ptr<const TextureTile> imagery;  ///< null where the pack has no imagery
  float geometric_error_m = 0;                 ///< of the height tile
  BoundingVolume volume;
  bool visible = false;   ///< false only if certainly outside the viewport or below the horizon
  double distance_m = 0;  ///< from the camera to the volume
};

/// The tiles to draw in a frame. With the invisible ones they cover the Earth, each place once.
struct RenderList {
  std::vector<RenderTile> tiles;
  std::uint64_t version = 0;  ///< unchanged if the areas and their data are those of the list before
  bool is_complete = false;   ///< this is the camera's scene map, and all its tiles could be read
  bool is_settled = false;  ///< nothing changes while the camera rests: complete, or the rest cannot be read
                            ///< at present and is tried again now and then
  bool is_limited = false;  ///< the camera's own map does not fit the budget; a coarser one is drawn
  double lowest_m = 0;      ///< no ground of the pack is lower
  std::vector<TileKey> evicted;  ///< no longer in memory since the last update: drop what was made of them
  /// What went wrong since the last update: tiles that are damaged or whose reads go on failing, each once,
  /// and a view that is out of range, once until a view is in range again.
  std::vector<Error> errors;
};

}  // namespace cairn
