#include "cairn/tile_id.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace cairn {

double tile_width_degrees(int level) {
  return std::ldexp(1.0, -level);
}

std::int32_t tiles_around(int level) {
  return level >= 0 ? 360 << level : (360 + (1 << -level) - 1) >> -level;
}

std::int32_t tiles_pole_to_pole(int level) {
  return level >= 0 ? 180 << level : (180 + (1 << -level) - 1) >> -level;
}

bool is_valid(const TileId& id) {
  return id.level >= kMinLevel && id.level <= kMaxLevel && id.x >= 0 && id.x < tiles_around(id.level) &&
         id.y >= 0 && id.y < tiles_pole_to_pole(id.level);
}

TileId tile_at(LonLat place, int level) {
  assert(level >= kMinLevel && level <= kMaxLevel);
  double east = std::fmod(place.lon + 180.0, 360.0);
  if (east < 0) east += 360.0;
  if (east >= 360.0) east = 0.0;  // -1e-20 + 360 rounds to 360
  const double north = std::fmin(std::fmax(place.lat + 90.0, 0.0), 180.0);
  const auto x = static_cast<std::int32_t>(std::ldexp(east, level));
  const auto y = static_cast<std::int32_t>(std::ldexp(north, level));
  return {level, x, std::min(y, tiles_pole_to_pole(level) - 1)};
}

GeoBounds tile_bounds(const TileId& id) {
  const double width = tile_width_degrees(id.level);
  const double west = id.x * width - 180.0;
  const double south = id.y * width - 90.0;
  return {west, south, west + width, south + width};
}

GeoBounds without_overhang(GeoBounds bounds) {
  bounds.east = std::min(bounds.east, 180.0);
  bounds.north = std::min(bounds.north, 90.0);
  return bounds;
}

TileId parent_of(const TileId& id) {
  assert(id.level > kMinLevel);
  return {id.level - 1, id.x >> 1, id.y >> 1};
}

TileId ancestor_of(const TileId& id, int level) {
  assert(level <= id.level && level >= kMinLevel);
  const int up = id.level - level;
  return {level, id.x >> up, id.y >> up};
}

TileId child_of(const TileId& id, int quadrant) {
  assert(quadrant >= 0 && quadrant < 4 && id.level < kMaxLevel);
  return {id.level + 1, id.x * 2 + (quadrant & 1), id.y * 2 + (quadrant >> 1)};
}

int quadrant_of(const TileId& id) {
  return (id.x & 1) | (id.y & 1) << 1;
}

TileId neighbour_of(const TileId& id, std::int32_t dx, std::int32_t dy) {
  const std::int32_t around = tiles_around(id.level);
  const std::int32_t x = (id.x + dx % around + around) % around;
  return {id.level, x, id.y + dy};
}

std::string to_string(const TileId& id) {
  return std::to_string(id.level) + "/" + std::to_string(id.x) + "/" + std::to_string(id.y);
}

}  // namespace cairn
