#pragma once

// Objects: things that stand on the ground, such as trees and houses. A pack names each model once, in
// Layer::models, and has the places in Layer::objects. docs/pack-format.md has the bytes.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cairn/body.h"
#include "cairn/geo.h"
#include "cairn/status.h"
#include "cairn/tile_id.h"

namespace cairn {

inline constexpr std::size_t kMostObjects = std::size_t{1} << 20;  ///< in one tile

/// The place of one object. Its foot is `height_quanta` above the ground; at heading 0, east, north and up of
/// the model are those of the place.
struct PlacedObject {
  std::int32_t height_quanta = 0;  ///< of the foot above the pack's finest ground; 0 stands on it
  std::uint16_t model = 0;         ///< its number in the pack: PackReader::read_model()
  std::uint16_t x = 0;             ///< (x + ½)/65536 of the tile's width east of its western edge
  std::uint16_t y = 0;             ///< (y + ½)/65536 of the tile's height north of its southern edge
  std::uint16_t heading = 0;       ///< clockwise from north, in 1/65536 turns
  std::uint16_t scale = 4096;      ///< in 1/4096; 1 or more

  double heading_degrees() const { return heading * (360.0 / 65536); }
  double scale_factor() const { return scale / 4096.0; }

  friend bool operator==(const PlacedObject&, const PlacedObject&) = default;
};

/// The objects that a tile has itself.
///
/// An object is in one tile only, that of object_level() for its size, which contains its foot. So those that
/// may be seen from a place are in the tiles of all levels around it: the tile of level L has none smaller
/// than 1/512 of its height, and its entry's geometric error is the size of the largest in it or beneath it.
/// The layer begins at the coarsest level of the heights. A tile that only leads to finer ones is constant.
struct ObjectTile {
  /// The lowest and the highest foot, as they stand on the pack's finest ground. Models reach beyond.
  std::int32_t lowest_quanta = 0;
  std::int32_t highest_quanta = 0;
  std::vector<PlacedObject> objects;  ///< by model, then along the Z curve of x and y

  friend bool operator==(const ObjectTile&, const ObjectTile&) = default;
};

/// Returns the place of an object's foot in degrees, inside the tile.
LonLat place_of(const TileId& tile, const PlacedObject& object);

/// Returns the level of the tile that has an object of this size (ObjectModel::size_m() times its scale): the
/// coarsest of which the size is 1/512 of a tile's height or more; kMaxLevel if there is none.
int object_level(double size_m, const Body& body);

/// Returns the foot's height in quanta, where the ground has this height. Throughout cairn a foot is rounded
/// so.
std::int64_t foot_quanta(const PlacedObject& object, double ground_m, double quantum_m);

/// Sorts as a tile has them.
void sort_objects(std::vector<PlacedObject>& objects);

/// Returns the block of a tile. Equal tiles give equal bytes. REQUIRES: 1 to kMostObjects objects, sorted;
/// scales above 0; lowest <= highest.
std::vector<std::byte> encode_object_block(const ObjectTile& tile);

/// Decodes a block. The error is bad_data if it is no block of objects, or if bytes are left over.
Result<ObjectTile> decode_object_block(std::span<const std::byte> block);

}  // namespace cairn
