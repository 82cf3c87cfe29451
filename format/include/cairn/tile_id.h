#pragma once

#include <compare>
#include <cstdint>
#include <functional>
#include <string>

#include "cairn/geo.h"

namespace cairn {

inline constexpr int kMinLevel = -9;  ///< one tile for the whole Earth
inline constexpr int kMaxLevel = 20;  ///< 2^-20 degree a tile: 0.2 mm a sample; x stays below 2^29

/// The address of a tile: level L tiles are 2^-L degrees wide, and x, y count them from 180°W, 90°S, so that
/// x = floor((lon+180)·2^L), y = floor((lat+90)·2^L). Level 0 is one tile a 1° cell.
///
/// x wraps at the antimeridian. Where 360 (or 180) degrees are no multiple of the tile's width (L < -3, L <
/// -2) the last tile of a row (column) overhangs the world; the overhang is void.
struct TileId {
  int level = 0;
  std::int32_t x = 0;
  std::int32_t y = 0;

  /// By level, then row, then column: the order of a pack's index.
  friend constexpr std::strong_ordering operator<=>(const TileId& a, const TileId& b) {
    if (auto c = a.level <=> b.level; c != 0) return c;
    if (auto c = a.y <=> b.y; c != 0) return c;
    return a.x <=> b.x;
  }
  friend constexpr bool operator==(const TileId&, const TileId&) = default;
};

/// Degrees along a side of a tile of this level: 2^-level, exact.
double tile_width_degrees(int level);

/// Tiles around the Earth, and from pole to pole, the overhanging last one counted.
std::int32_t tiles_around(int level);
std::int32_t tiles_pole_to_pole(int level);

/// Whether level, x and y are in range.
bool is_valid(const TileId& id);

/// The tile of this level that holds the place; places on a shared edge belong to the tile east and north of
/// it, but lat = 90 to the northernmost tile. Longitudes outside [-180, 180) are wrapped first.
TileId tile_at(LonLat place, int level);

/// West, south, east, north; exact. May reach past 180 and 90 where the tile overhangs.
GeoBounds tile_bounds(const TileId& id);
/// Without what lies past 180 and 90: wrapped around the Earth, an overhang would lie over places that are
/// none of the tile's.
GeoBounds without_overhang(GeoBounds bounds);

/// The tile one level coarser that covers this one. REQUIRES: level > kMinLevel.
TileId parent_of(const TileId& id);

/// The ancestor at a level no finer than the tile's own.
TileId ancestor_of(const TileId& id, int level);

/// Child 0…3: bit 0 is east, bit 1 is north. It may be invalid (north of the pole, east of 180°): ask
/// is_valid().
TileId child_of(const TileId& id, int quadrant);

/// Which child of its parent the tile is.
int quadrant_of(const TileId& id);

/// The tile dx columns east and dy rows north, wrapped around the Earth in x; may be invalid in y.
TileId neighbour_of(const TileId& id, std::int32_t dx, std::int32_t dy);

/// "L/X/Y", as the programs print and read it.
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
