#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>

#include "cairn/tile_id.h"

namespace cairn {

/// log2 of the lattice's units per degree: the sample spacing of tiles of 513 at level 20.
inline constexpr int kLatticeLevel = kMaxLevel + 9;
inline constexpr std::int64_t kLatticeAround = std::int64_t{360} << kLatticeLevel;
inline constexpr std::int64_t kLatticePoleToPole = std::int64_t{180} << kLatticeLevel;

/// A place on the finest possible sample grid, in units of 2^-29 degree from 180°W and 90°S. Exact for every
/// sample of every tile.
struct LatticePoint {
  std::int64_t x = 0;
  std::int64_t y = 0;
  friend constexpr bool operator==(const LatticePoint&, const LatticePoint&) = default;
};

/// Returns the units along the side of a tile.
constexpr std::int64_t lattice_width(int level) {
  return std::int64_t{1} << (kLatticeLevel - level);
}
constexpr LatticePoint south_west_of(const TileId& id) {
  return {id.x * lattice_width(id.level), id.y * lattice_width(id.level)};
}

/// Returns the point of this place with 0 <= x < kLatticeAround. REQUIRES: 0 <= x <= kLatticeAround.
constexpr LatticePoint canonical(LatticePoint point) {
  if (point.x >= kLatticeAround) point.x -= kLatticeAround;
  return point;
}

/// Returns degrees, exact: lon -180 to 180, lat -90 to 90.
constexpr LonLat place_of(const LatticePoint& point) {
  constexpr double kDegree = 1.0 / (std::int64_t{1} << kLatticeLevel);
  return {static_cast<double>(point.x) * kDegree - 180.0, static_cast<double>(point.y) * kDegree - 90.0};
}

}  // namespace cairn

template <>
struct std::hash<cairn::LatticePoint> {
  std::size_t operator()(const cairn::LatticePoint& p) const noexcept {
    const auto x = static_cast<std::uint64_t>(p.x), y = static_cast<std::uint64_t>(p.y);
    return static_cast<std::size_t>((x * 0x9E3779B97F4A7C15u) ^ ((y * 0xBF58476D1CE4E5B9u) >> 7));
  }
};
