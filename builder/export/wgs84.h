#pragma once

namespace cairn {

inline constexpr double kEquatorRadius_m = 6378137.0;
inline constexpr double kPoleRadius_m = 6356752.3142451793;

/// Metres of a degree of longitude and of latitude on the ellipsoid at this latitude.
struct DegreeLengths {
  double lon_m = 0;
  double lat_m = 0;
};
DegreeLengths degree_lengths(double lat);

}  // namespace cairn
