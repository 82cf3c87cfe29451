#pragma once

#include <glm/vec3.hpp>

namespace cairn {

/// Returns the direction to the sun from the Earth's centre, geocentric, of unit length, at so many seconds
/// since 1970 UTC. It is right to 0.02° from 1950 to 2050 (Astronomical Almanac, section C, "low precision
/// formulas"); the sun's parallax, 0.0024°, is left out.
glm::dvec3 sun_position(double utc_s);

}  // namespace cairn
