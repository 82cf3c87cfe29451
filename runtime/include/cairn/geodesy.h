#pragma once

#include <numbers>

#include <glm/vec3.hpp>

#include "cairn/geo.h"

namespace cairn {

/// The radii of WGS84, in metres.
inline constexpr double kEquatorialRadius = 6378137.0;
inline constexpr double kPolarRadius = 6356752.314245179;

/// Metres per degree of the equator.
inline constexpr double kEquatorDegree_m = kEquatorialRadius * std::numbers::pi / 180;
/// Metres per degree of a meridian, rounded: for rules of thumb, not for places.
inline constexpr double kMeridianDegree_m = 111e3;

/// A place and its height above the ellipsoid, in metres.
struct Geodetic {
  LonLat place;
  double height_m = 0;
};

/// Convert to and from Earth-centred, Earth-fixed metres: x through 0°E, y through 90°E, z through the north
/// pole. Errors are a few nanometres (GeographicLib; Karney 2011).
glm::dvec3 to_geocentric(LonLat place, double height_m);
Geodetic to_geodetic(const glm::dvec3& geocentric);

/// Unit vectors to the east, the north and up (the ellipsoid's normal) at a place; at a pole those of its
/// meridian.
struct LocalFrame {
  glm::dvec3 east;
  glm::dvec3 north;
  glm::dvec3 up;
};
LocalFrame local_frame(LonLat place);

}  // namespace cairn
