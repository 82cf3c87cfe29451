#pragma once

#include <array>
#include <span>
#include <vector>

#include <glm/vec3.hpp>

#include "cairn/bounding_volume.h"
#include "runtime/view/horizon.h"
#include "cairn/view_state.h"

namespace cairn {

/// What one view can see: the pyramid of its picture, above the horizon. Never says no to what can be seen;
/// may say yes to what cannot. Seed [2] §4.2 scan-converts the view volume on the tile grid instead; with
/// some hundred tiles a map, testing each is as quick and works on the globe.
class ViewFrustum {
 public:
  ViewFrustum(const ViewState& view, const Occluder& occluder);

  bool sees(const BoundingVolume& volume) const;
  const glm::dvec3& eye() const { return eye_; }

 private:
  bool in_pyramid(const BoundingVolume& volume) const;

  glm::dvec3 eye_;
  std::array<glm::dvec3, 5> inward_;  // normals of planes through the eye: four sides, and in front
  Horizon horizon_;
};

}  // namespace cairn
