#pragma once

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "cairn/bounding_volume.h"

namespace cairn {

/// Tests what an occluder hides from one camera. From inside the occluder nothing is hidden.
/// With each axis divided by the occluder's radius, the occluder is the unit sphere. Hidden is what lies
/// inside the cone from the camera around it and behind the circle where they touch (Cozzi & Ring 2011).
/// Immutable.
class Horizon {
 public:
  /// `eye` is the camera's position. All places are in geocentric metres.
  Horizon(const glm::dvec3& eye, const Occluder& occluder)
      : per_radius_(1.0 / occluder.radii),
        eye_(eye * per_radius_),
        distance_(glm::length(eye_)),
        square_(glm::dot(eye_, eye_) - 1) {}

  bool hides(const glm::dvec3& point) const { return hides_scaled(point * per_radius_); }

  /// Returns true only if all of the tile is hidden.
  bool hides(const BoundingVolume& volume) const {
    return volume.horizon_point && hides_scaled(*volume.horizon_point);
  }

  /// Returns true only if all of the sphere is hidden: its centre is inside the cone by its radius.
  bool hides(const glm::dvec3& centre, double radius_m) const {
    if (square_ <= 0) return false;
    const double radius = radius_m * per_radius_.z;
    const glm::dvec3 to = centre * per_radius_ - eye_;
    const double along = -glm::dot(to, eye_) / distance_;
    if (along * distance_ < square_ + radius * distance_) return false;
    const double across = std::sqrt(std::max(0.0, glm::dot(to, to) - along * along));
    return along - across * std::sqrt(square_) >= radius * distance_;
  }

 private:
  bool hides_scaled(const glm::dvec3& point) const {
    if (square_ <= 0) return false;
    const glm::dvec3 to = point - eye_;
    const double behind = -glm::dot(to, eye_);
    return behind > square_ && behind * behind > square_ * glm::dot(to, to);
  }

  glm::dvec3 per_radius_;  ///< the third is the largest
  glm::dvec3 eye_;         ///< in the space where the occluder is the unit sphere
  double distance_;        ///< of eye_ from the centre
  double square_;          ///< of the distance from eye_ to the horizon; <= 0 inside the occluder
};

}  // namespace cairn
