#include "builder/export/wgs84.h"

#include <cmath>
#include <numbers>

#include <GeographicLib/Geocentric.hpp>

namespace cairn {
namespace {

constexpr double kRadian = std::numbers::pi / 180;

}  // namespace

Vector3 geocentric(LonLat place, double height_m) {
  Vector3 v;
  GeographicLib::Geocentric::WGS84().Forward(place.lat, place.lon, height_m, v[0], v[1], v[2]);
  return v;
}

LocalAxes local_axes(LonLat place) {
  const double lon = place.lon * kRadian, lat = place.lat * kRadian;
  const double sl = std::sin(lon), cl = std::cos(lon), sp = std::sin(lat), cp = std::cos(lat);
  return {{-sl, cl, 0}, {-sp * cl, -sp * sl, cp}, {cp * cl, cp * sl, sp}};
}

DegreeLengths degree_lengths(double lat) {
  const double e2 = 1 - (kPoleRadius_m * kPoleRadius_m) / (kEquatorRadius_m * kEquatorRadius_m);
  const double s = std::sin(lat * kRadian), w = 1 - e2 * s * s;
  return {kRadian * std::cos(lat * kRadian) * kEquatorRadius_m / std::sqrt(w),
          kRadian * kEquatorRadius_m * (1 - e2) / (w * std::sqrt(w))};
}

}  // namespace cairn
