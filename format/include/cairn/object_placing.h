#pragma once

#include "cairn/body.h"
#include "cairn/geo.h"
#include "cairn/object_tile.h"
#include "cairn/tile_id.h"

namespace cairn {

/// An object that stands on the ground, before it is rounded to what a tile stores.
struct ObjectPlacing {
  LonLat at;
  double heading_degrees = 0;  ///< clockwise from north
  double scale = 1;            ///< 1/4096 to 65535/4096; what is beyond is clamped
  double size_m = 0;           ///< of the model at scale 1: ObjectModel::size_m()
};

/// An object in its tile.
struct TileObject {
  TileId tile;
  PlacedObject object;
};

/// Returns the tile that has an object, that of object_level() or of the coarsest level of the layer if that
/// is finer, and the object in it, on the ground and with model 0. REQUIRES: finite numbers, a latitude of
/// -90 to 90.
TileObject tile_object(const ObjectPlacing& placing, const Body& body, int coarsest_level = kMinLevel);

}  // namespace cairn
