#include "builder/export/geodesy.h"

#include <cmath>
#include <numbers>

#include <GeographicLib/Geocentric.hpp>

namespace cairn {
namespace {

constexpr double kRadian = std::numbers::pi / 180;

}  // namespace

Vector3 geocentric(LonLat place, double height_m, const Ellipsoid& ellipsoid) {
  Vector3 v;
  const GeographicLib::Geocentric body(ellipsoid.semi_major_m, ellipsoid.flattening());
  body.Forward(place.lat, place.lon, height_m, v[0], v[1], v[2]);
  return v;
}

LocalAxes local_axes(LonLat place) {
  const double lon = place.lon * kRadian, lat = place.lat * kRadian;
  const double sl = std::sin(lon), cl = std::cos(lon), sp = std::sin(lat), cp = std::cos(lat);
  return {{-sl, cl, 0}, {-sp * cl, -sp * sl, cp}, {cp * cl, cp * sl, sp}};
}

DegreeLengths degree_lengths(double lat, const Ellipsoid& ellipsoid) {
  const double a = ellipsoid.semi_major_m, e2 = 1 - 1 / ellipsoid.graphic_per_centric();
  const double s = std::sin(lat * kRadian), w = 1 - e2 * s * s;
  return {kRadian * std::cos(lat * kRadian) * a / std::sqrt(w), kRadian * a * (1 - e2) / (w * std::sqrt(w))};
}

}  // namespace cairn
