#include "runtime/view/view_frustum.h"

#include <cmath>

#include <glm/geometric.hpp>

namespace cairn {

ViewFrustum::ViewFrustum(const ViewState& view, const Occluder& occluder)
    : eye_(camera_frame(view).position),
      inward_(inward_normals(camera_frame(view), view)),
      horizon_(eye_, occluder) {}

bool ViewFrustum::sees(const BoundingVolume& volume) const {
  return in_pyramid(volume) && !horizon_.hides(volume);
}

bool ViewFrustum::in_pyramid(const BoundingVolume& volume) const {
  const glm::dvec3 to = volume.centre - eye_;
  for (const glm::dvec3& normal : inward_) {
    const double reach = std::abs(glm::dot(volume.half_axes[0], normal)) +
                         std::abs(glm::dot(volume.half_axes[1], normal)) +
                         std::abs(glm::dot(volume.half_axes[2], normal));
    if (glm::dot(to, normal) + reach < 0) return false;
  }
  return true;
}

}  // namespace cairn
