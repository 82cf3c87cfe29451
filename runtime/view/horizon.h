#pragma once

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "cairn/bounding_volume.h"

namespace cairn {

/// What the occluder hides from one eye. Where each axis is divided by its radius the occluder is the unit
/// sphere: hidden is what lies in the cone from the eye around it and behind where they touch. From inside
/// the occluder nothing is.
class Horizon {
 public:
  /// `eye`: geocentric metres, like all that is asked about below.
  Horizon(const glm::dvec3& eye, const Occluder& occluder)
      : per_radius_(1.0 / occluder.radii),
        eye_(eye * per_radius_),
        distance_(glm::length(eye_)),
        square_(glm::dot(eye_, eye_) - 1) {}

  bool hides(const glm::dvec3& point) const { return hides_scaled(point * per_radius_); }

  /// All of the tile; never says yes where some of it is seen.
  bool hides(const BoundingVolume& volume) const {
    return volume.horizon_point && hides_scaled(*volume.horizon_point);
  }

  /// All of a sphere, if its middle is within the cone by its radius; never says yes where some of it is
  /// seen.
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
  glm::dvec3 eye_;         ///< where the occluder is the unit sphere
  double distance_;        ///< of the eye there
  double square_;          ///< of the distance from there to the horizon; <= 0 inside
};

}  // namespace cairn
