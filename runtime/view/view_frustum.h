#pragma once

#include <array>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "cairn/bounding_volume.h"
#include "cairn/view_state.h"
#include "runtime/view/horizon.h"

namespace cairn {

/// Tests what is inside the view frustum and above the horizon. May return true for what is invisible.
/// Leung (1995, §4.2) scan-converts the view volume on the tile grid instead. Testing each of some hundred
/// tiles works on the whole globe.
class ViewFrustum {
 public:
  ViewFrustum(const ViewState& view, const Occluder& occluder);

  /// Returns false only if no part of the volume is visible.
  bool sees(const BoundingVolume& volume) const;
  const glm::dvec3& eye() const { return eye_; }

 private:
  bool in_pyramid(const BoundingVolume& volume) const;

  glm::dvec3 eye_;
  std::array<glm::dvec3, 5> inward_;  // normals of planes through the camera: four sides, and the front
  Horizon horizon_;
};

}  // namespace cairn
