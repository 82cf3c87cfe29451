#include "runtime/visible_set.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace cairn {
ViewVolume::ViewVolume(const ViewState& view, const Occluder& occluder) {
  const CameraFrame camera = camera_frame(view);
  eye_ = camera.position;
  inward_ = inward_normals(camera, view);
  scaled_eye_ = eye_ / occluder.radii;
  horizon_square_ = glm::dot(scaled_eye_, scaled_eye_) - 1;
}

bool ViewVolume::sees(const BoundingVolume& volume) const {
  return in_pyramid(volume) && above_horizon(volume);
}

bool ViewVolume::in_pyramid(const BoundingVolume& volume) const {
  const glm::dvec3 to = volume.centre - eye_;
  for (const glm::dvec3& normal : inward_) {
    const double reach = std::abs(glm::dot(volume.half_axes[0], normal)) +
                         std::abs(glm::dot(volume.half_axes[1], normal)) +
                         std::abs(glm::dot(volume.half_axes[2], normal));
    if (glm::dot(to, normal) + reach < 0) return false;
  }
  return true;
}

bool ViewVolume::above_horizon(const BoundingVolume& volume) const {
  if (!volume.horizon_point || horizon_square_ <= 0) return true;
  const glm::dvec3 to = *volume.horizon_point - scaled_eye_;
  const double behind = -glm::dot(to, scaled_eye_);
  return behind <= horizon_square_ || behind * behind <= horizon_square_ * glm::dot(to, to);
}

}  // namespace cairn
