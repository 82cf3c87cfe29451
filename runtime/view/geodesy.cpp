#include "cairn/geodesy.h"

#include <cmath>

#include <GeographicLib/Geocentric.hpp>
#include <glm/trigonometric.hpp>

namespace cairn {

namespace {

GeographicLib::Geocentric geocentric_of(const Ellipsoid& ellipsoid) {
  return {ellipsoid.semi_major_m, ellipsoid.flattening()};
}

}  // namespace

glm::dvec3 to_geocentric(LonLat place, double height_m, const Ellipsoid& ellipsoid) {
  glm::dvec3 p;
  geocentric_of(ellipsoid).Forward(place.lat, place.lon, height_m, p.x, p.y, p.z);
  return p;
}

Geodetic to_geodetic(const glm::dvec3& geocentric, const Ellipsoid& ellipsoid) {
  Geodetic g;
  geocentric_of(ellipsoid).Reverse(geocentric.x, geocentric.y, geocentric.z, g.place.lat, g.place.lon,
                                   g.height_m);
  return g;
}

LocalFrame local_frame(LonLat place) {
  const double lon = glm::radians(place.lon);
  const double lat = glm::radians(place.lat);
  const double sl = std::sin(lon), cl = std::cos(lon), sp = std::sin(lat), cp = std::cos(lat);
  return {{-sl, cl, 0}, {-sp * cl, -sp * sl, cp}, {cp * cl, cp * sl, sp}};
}

}  // namespace cairn
