#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "cairn/bounding_volume.h"
#include "cairn/loaded_objects.h"
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
  float finer_error_m = 0;  ///< how far the pack's finest heights may lie from these; 0 where these are they
  BoundingVolume volume;
  bool visible = false;       ///< false only if certainly outside all viewports or below their horizons
  std::uint64_t seen_by = 0;  ///< bit i: visible in view i of the update
  double distance_m = 0;      ///< from the nearest camera to the volume
};

/// The tiles to draw in a frame. With the invisible ones they cover the Earth, each place once.
struct RenderList {
  std::vector<RenderTile> tiles;
  /// The tiles of objects that are in memory and have some that are large enough to be drawn. An object is in
  /// one tile only, whatever tile of heights is drawn where it stands.
  std::vector<std::shared_ptr<const LoadedObjects>> objects;
  std::uint64_t version = 0;  ///< unchanged if the areas and their data are those of the list before
  bool is_complete = false;   ///< these are the tiles that the views need, and all could be read
  bool is_settled = false;  ///< nothing changes while the cameras rest: complete, or the rest cannot be read
                            ///< at present and is tried again now and then
  bool is_limited = false;  ///< the tiles that the views need do not fit the budget
  /// The largest screen error, in pixels, that the heights drawn now may have in any view against the
  /// pack's finest, loading and budget as they are; infinite where ground beside a camera is coarse.
  double error_px = 0;
  /// The widest texel, in pixels, that is drawn now in any view where the pack has finer ones.
  double texel_px = 0;
  double lowest_m = 0;           ///< no ground of the pack is lower
  std::vector<TileKey> evicted;  ///< no longer in memory since the last update: drop what was made of them
  /// What went wrong since the last update: tiles that are damaged or whose reads go on failing, each once,
  /// and a view that is out of range, once until a view is in range again.
  std::vector<Error> errors;
};

}  // namespace cairn
