#pragma once

#include <array>

#include "cairn/geo.h"

namespace cairn {

inline constexpr double kEquatorRadius_m = 6378137.0;
inline constexpr double kPoleRadius_m = 6356752.3142451793;

using Vector3 = std::array<double, 3>;

/// Geocentric metres (EPSG:4978) of a place at a height above the WGS84 ellipsoid.
Vector3 geocentric(LonLat place, double height_m);

/// Unit vectors of a place.
struct LocalAxes {
  Vector3 east, north, up;
};
LocalAxes local_axes(LonLat place);

/// Metres of a degree of longitude and of latitude on the ellipsoid at this latitude.
struct DegreeLengths {
  double lon_m = 0;
  double lat_m = 0;
};
DegreeLengths degree_lengths(double lat);

}  // namespace cairn
