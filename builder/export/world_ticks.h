#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "cairn/geo.h"
#include "cairn/tile_id.h"

namespace cairn {

/// Places as whole numbers of 2^-30 degree from 180°W, 90°S. All tile edges and samples of a pack lie on such
/// places, so that comparisons are exact.
struct TickRect {
  std::int64_t west = 0;
  std::int64_t south = 0;
  std::int64_t east = 0;
  std::int64_t north = 0;

  std::int64_t width() const { return east - west; }
  std::int64_t height() const { return north - south; }
};

/// What two rectangles have in common; of no width or height where that is nothing.
inline TickRect intersection(const TickRect& a, const TickRect& b) {
  return {std::max(a.west, b.west), std::max(a.south, b.south), std::min(a.east, b.east),
          std::min(a.north, b.north)};
}

inline constexpr int kTickBits = 30;  ///< of a degree
inline constexpr std::int64_t kTicksAround = std::int64_t{360} << kTickBits;
inline constexpr std::int64_t kTicksPoleToPole = std::int64_t{180} << kTickBits;

/// Ticks along a side of a tile of this level.
inline std::int64_t tile_ticks(int level) {
  return std::int64_t{1} << (kTickBits - level);
}

/// The whole tile, with what overhangs the world.
inline TickRect ticks_of(const TileId& id) {
  const std::int64_t side = tile_ticks(id.level);
  return {id.x * side, id.y * side, (id.x + 1) * side, (id.y + 1) * side};
}

/// Exact.
inline LonLat place_of(std::int64_t x, std::int64_t y) {
  return {std::ldexp(static_cast<double>(x), -kTickBits) - 180,
          std::ldexp(static_cast<double>(y), -kTickBits) - 90};
}

}  // namespace cairn
