#pragma once

#include <glm/vec3.hpp>

#include "cairn/body.h"
#include "cairn/geo.h"

namespace cairn {

/// A place and its height above the ellipsoid, in metres.
struct Geodetic {
  LonLat place;
  double height_m = 0;
};

/// Convert to and from metres along axes that are fixed to the body, from its centre: x through 0°E, y
/// through 90°E, z through the north pole. The ellipsoid is by default that of WGS84; PackHeader::body has a
/// pack's. Errors are a few nanometres on the Earth (GeographicLib; Karney 2011).
glm::dvec3 to_geocentric(LonLat place, double height_m, const Ellipsoid& ellipsoid = {});
Geodetic to_geodetic(const glm::dvec3& geocentric, const Ellipsoid& ellipsoid = {});

/// Returns the largest and the least radius of curvature of an ellipsoid, in metres: a²/b and b²/a.
inline double largest_curvature_m(const Ellipsoid& e) {
  return e.semi_major_m * (e.semi_major_m / e.semi_minor_m);
}
inline double least_curvature_m(const Ellipsoid& e) {
  return e.semi_minor_m * (e.semi_minor_m / e.semi_major_m);
}

/// Unit vectors to the east, the north and up (the ellipsoid's normal) at a place; at a pole those of its
/// meridian.
struct LocalFrame {
  glm::dvec3 east;
  glm::dvec3 north;
  glm::dvec3 up;
};
LocalFrame local_frame(LonLat place);

}  // namespace cairn
