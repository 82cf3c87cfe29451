#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "cairn/geo.h"

namespace cairn {

/// The ellipsoid that no terrain goes below, so that what it hides is hidden.
struct Occluder {
  /// REQUIRES: lowest_m > -100 km. Heights above the ellipsoid make no difference.
  explicit Occluder(double lowest_m);
  glm::dvec3 radii;
};

/// What encloses the surface of a tile, in geocentric metres.
struct BoundingVolume {
  glm::dvec3 centre{0};
  glm::dvec3 half_axes[3]{};  ///< of a box: east, north and up at the middle of the area, times its half-size

  /// A point in the occluder's scaled space (each axis divided by its radius) that is hidden only where the
  /// whole tile is; nullopt where the tile is too large for one. P. Cozzi and K. Ring, "3D Engine Design for
  /// Virtual Globes", 2011, and K. Ring, "Horizon Culling 2", 2013.
  std::optional<glm::dvec3> horizon_point;

  double distance_m(const glm::dvec3& point) const;  ///< to the box; 0 inside
};

/// Encloses every point of the area between the heights. The area is sampled at 5×5 places; between them the
/// surface leaves the samples' convex hull by (R+h)(δφ²+δλ²)/8 at most (the error of linear interpolation, δ
/// the step in radians), which the volume is grown by. Parts of the area beyond 180°E or the pole do not
/// count. REQUIRES: min_m <= max_m.
BoundingVolume bounding_volume(const GeoBounds& area, double min_m, double max_m, const Occluder& occluder);

}  // namespace cairn
