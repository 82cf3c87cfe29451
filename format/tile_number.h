#pragma once

#include <cstdint>
#include <optional>

#include "cairn/pack_layout.h"
#include "cairn/tile_id.h"

namespace cairn {

/// A place along the Z curve: the bits of x at the even places, those of y at the odd ones. REQUIRES: x and y
/// below 2^32.
std::uint64_t z_curve(std::uint64_t x, std::uint64_t y);

/// The tile's number: levels from the coarsest on, within a level along a Z curve, so that the children of a
/// tile have four numbers in a row, in the order of their quadrants. Below 2^59.
///
/// A level has 4^(level + 9) numbers, of which those beyond 360 and 180 degrees are not used.
std::uint64_t tile_number(const TileId& id);

/// The tile of a number; nullopt where it is no tile of the grid.
std::optional<TileId> tile_of_number(std::uint64_t number);

/// What the index is sorted by: the layer, then the tile's number.
inline std::uint64_t index_key_of(Layer layer, const TileId& id) {
  return static_cast<std::uint64_t>(layer) << 59 | tile_number(id);
}
inline std::uint64_t index_key_of(const IndexEntry& entry) {
  return index_key_of(entry.layer, entry.id);
}

/// A layer's tile.
struct LayerTile {
  Layer layer = Layer::heights;
  TileId id;
};
/// The inverse of index_key_of(); nullopt where there is no such layer or tile.
std::optional<LayerTile> tile_of_key(std::uint64_t key);

}  // namespace cairn
