#pragma once

#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "runtime/bounding_volume.h"

namespace cairn {

/// Whether the ellipsoid hides a point; see BoundingVolume.
class Horizon {
 public:
  Horizon(const glm::dvec3& eye, const Occluder& occluder)
      : radii_(occluder.radii), eye_(eye / occluder.radii), square_(glm::dot(eye_, eye_) - 1) {}

  bool hides(const glm::dvec3& point) const {
    if (square_ <= 0) return false;
    const glm::dvec3 to = point / radii_ - eye_;
    const double behind = -glm::dot(to, eye_);
    return behind > square_ && behind * behind > square_ * glm::dot(to, to);
  }

 private:
  glm::dvec3 radii_;
  glm::dvec3 eye_;
  double square_;
};

}  // namespace cairn
