#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "cairn/height_tile.h"
#include "cairn/tile_id.h"
#include "runtime/light/shadow_ground.h"

namespace cairn {

/// The angle above the sun's middle up to which ground is in the way, of a texel of 127; it is below it for
/// negative texels. The sun's radius seen from the Earth is 0.267°.
inline constexpr double kShadowRange_deg = 2;

/// Returns, for each sample of a tile, how far ground towards the sun rises above the line to the sun's
/// middle: its angle in units of kShadowRange_deg / 127, at most ±127. A place is in shadow where it is > 0.
///
/// Light comes in parallel lines from `to_sun`, a unit vector in the body's axes; the body's curvature and
/// all ground of the pack within 400 km count. Nearby ground is that of the tile's own level, far ground that
/// of a level whose samples are a 250th of the distance apart. Along lines towards the sun, one for each row
/// or column, the upper hull of what lies ahead gives each sample's horizon in constant time (Timonen &
/// Westerholm 2010). Takes some 50 ms for 513 samples a side.
std::vector<std::int8_t> tile_shadow(ShadowGround& ground, const TileId& id, const HeightTile& heights,
                                     const glm::dvec3& to_sun);

}  // namespace cairn
