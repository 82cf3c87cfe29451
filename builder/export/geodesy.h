#pragma once

#include <array>

#include "cairn/body.h"
#include "cairn/geo.h"

namespace cairn {

using Vector3 = std::array<double, 3>;

/// Metres from the body's centre (on the Earth EPSG:4978) of a place at a height above the ellipsoid.
Vector3 geocentric(LonLat place, double height_m, const Ellipsoid& ellipsoid);

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
DegreeLengths degree_lengths(double lat, const Ellipsoid& ellipsoid);

}  // namespace cairn
