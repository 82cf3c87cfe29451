#pragma once

#include <string>

#include <GeographicLib/TransverseMercator.hpp>

#include "cairn/body.h"
#include "cairn/geo.h"
#include "cairn/status.h"

namespace cairn {

/// Metres from the origin of a plane.
struct PlanePoint {
  double east_m = 0;
  double north_m = 0;
};

/// Metres east and north of a place, by a transverse Mercator projection around it that keeps lengths at its
/// meridian: 1e-4 is lost 90 km away from it.
class LocalPlane {
 public:
  LocalPlane(LonLat centre, const Ellipsoid& ellipsoid);

  LonLat centre() const { return centre_; }
  std::string description() const;
  PlanePoint to_plane(LonLat place) const;
  LonLat to_place(PlanePoint point) const;

  /// Radians clockwise from true north to the plane's north.
  double convergence(LonLat place) const;

 private:
  GeographicLib::TransverseMercator projection_;
  LonLat centre_;
  double origin_ = 0;
};

/// A rectangle on a plane, metres.
struct PlaneRect {
  double west_m = 0;
  double south_m = 0;
  double east_m = 0;
  double north_m = 0;
};

/// What the region's rim encloses on the plane. usage where that is wider than a plane can stand for.
Result<PlaneRect> rim_on_plane(const LocalPlane& plane, const GeoBounds& region);

}  // namespace cairn
