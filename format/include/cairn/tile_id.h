#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <string>

#include "cairn/geo.h"

namespace cairn {

inline constexpr int kMinLevel = -9;  ///< one tile for the whole Earth
inline constexpr int kMaxLevel = 20;  ///< tiles of 2^-20 degree, samples 0.2 mm apart; x stays below 2^29

/// The address of a tile. Tiles of level L are 2^-L degrees wide; x and y count them from 180°W, 90°S:
/// x = floor((lon+180)·2^L), y = floor((lat+90)·2^L). Level 0 has one tile per cell of 1°.
///
/// x wraps at the antimeridian. Where 360 (or 180) degrees are no multiple of the tile's width (L < -3, L <
/// -2) the last tile of a row (column) overhangs the world; the overhang is void.
struct TileId {
  int level = 0;
  std::int32_t x = 0;
  std::int32_t y = 0;

  /// Orders by level, then row, then column, as a pack's index.
  friend constexpr std::strong_ordering operator<=>(const TileId& a, const TileId& b) {
    if (auto c = a.level <=> b.level; c != 0) return c;
    if (auto c = a.y <=> b.y; c != 0) return c;
    return a.x <=> b.x;
  }
  friend constexpr bool operator==(const TileId&, const TileId&) = default;
};

/// Returns the degrees along a side of a tile: 2^-level, exact.
double tile_width_degrees(int level);

/// Return the number of tiles around the Earth, and from pole to pole, the overhanging last one included.
std::int32_t tiles_around(int level);
std::int32_t tiles_pole_to_pole(int level);

/// Returns whether level, x and y are in range.
bool is_valid(const TileId& id);

/// Returns the tile of this level that contains the place. Places on a shared edge belong to the tile east
/// and north of it, lat = 90 to the northernmost tile. Longitudes outside [-180, 180) are wrapped first.
TileId tile_at(LonLat place, int level);

/// Returns a tile's bounds, exact. They reach past 180 and 90 where the tile overhangs the world.
GeoBounds tile_bounds(const TileId& id);
/// Returns the bounds cut at 180 and 90. Wrapped around the Earth, an overhang would lie over places that are
/// not the tile's.
GeoBounds without_overhang(GeoBounds bounds);

/// Returns the tile one level coarser that covers this one. REQUIRES: level > kMinLevel.
TileId parent_of(const TileId& id);

/// Returns the ancestor at a level. REQUIRES: the level is no finer than the tile's own.
TileId ancestor_of(const TileId& id, int level);

/// Returns child 0 to 3: bit 0 is east, bit 1 is north. The child may be invalid, north of the pole or east
/// of 180°.
TileId child_of(const TileId& id, int quadrant);

/// Returns which child of its parent the tile is.
int quadrant_of(const TileId& id);

/// Returns the tile dx columns east and dy rows north, wrapped around the Earth in x. It may be invalid in y.
TileId neighbour_of(const TileId& id, std::int32_t dx, std::int32_t dy);

/// Returns "L/X/Y", as the programs print and read it.
std::string to_string(const TileId& id);

}  // namespace cairn

template <>
struct std::hash<cairn::TileId> {
  std::size_t operator()(const cairn::TileId& id) const noexcept {
    const auto x = static_cast<std::uint64_t>(static_cast<std::uint32_t>(id.x));
    const auto y = static_cast<std::uint64_t>(static_cast<std::uint32_t>(id.y));
    std::uint64_t h = (x << 32 | y) * 0x9E3779B97F4A7C15u + static_cast<std::uint64_t>(id.level + 64);
    return static_cast<std::size_t>((h ^ h >> 29) * 0xBF58476D1CE4E5B9u);
  }
};
