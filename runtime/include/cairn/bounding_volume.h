#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "cairn/body.h"
#include "cairn/geo.h"

namespace cairn {

/// An ellipsoid that no terrain goes below, so that what it occludes is invisible.
struct Occluder {
  /// A lowest_m above 0 counts as 0. REQUIRES: lowest_m is above minus half the semi-minor axis.
  explicit Occluder(double lowest_m, const Ellipsoid& ellipsoid = {});
  Ellipsoid ellipsoid;  ///< of the body, from which heights are measured
  glm::dvec3 radii;     ///< of the occluder
};

/// A volume that encloses the surface of a tile, in geocentric metres.
struct BoundingVolume {
  glm::dvec3 centre{0};
  glm::dvec3 half_axes[3]{};  ///< of a box: east, north and up in the middle of the area, times half its size

  /// A point in the occluder's scaled space, each axis divided by its radius, that is hidden only where the
  /// whole tile is (Cozzi & Ring 2011; Ring 2013). nullopt if the tile is too large for one.
  std::optional<glm::dvec3> horizon_point;

  double distance_m(const glm::dvec3& point) const;  ///< from the box; 0 inside
};

/// Returns a volume that encloses every point of the area between the heights, on the occluder's ellipsoid.
/// The area is sampled at 5×5 places. Between them the surface leaves the samples' convex hull by at most
/// (R+h)(δφ²+δλ²)/8, the error of linear interpolation with δ the step in radians, and the volume is larger
/// by that. Parts of the area beyond 180°E or a pole do not count. REQUIRES: min_m <= max_m.
BoundingVolume bounding_volume(const GeoBounds& area, double min_m, double max_m, const Occluder& occluder);

/// Returns a volume that encloses all that is no farther from this one, never hidden by the horizon.
BoundingVolume grown(BoundingVolume volume, double metres);

}  // namespace cairn
