#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "cairn/view_state.h"

namespace cairn {

/// Follows the eye and says where it is going. The velocity is averaged over about a second, so that an eye
/// that shakes goes nowhere.
class MotionPredictor {
 public:
  /// Takes in the view of this update, and returns the view `ahead_s` later at the same velocity; the view
  /// itself where that is farther than `reach_m`, as after a jump.
  ViewState predict(const ViewState& view, double dt_s, double ahead_s, double reach_m);

 private:
  std::optional<glm::dvec3> position_;
  glm::dvec3 velocity_{0};  // m/s
};

}  // namespace cairn
