#pragma once

#include <optional>

#include <glm/vec3.hpp>

#include "cairn/view_state.h"

namespace cairn {

/// Predicts where the camera will be. Its velocity is averaged over about a second, so that a camera that
/// shakes has none.
class MotionPredictor {
 public:
  /// Returns the view `ahead_s` after this one at the present velocity; the view itself if that is farther
  /// away than `reach_m`, as after a jump.
  ViewState predict(const ViewState& view, double dt_s, double ahead_s, double reach_m);

 private:
  std::optional<glm::dvec3> position_;
  glm::dvec3 velocity_{0};  // m/s
};

}  // namespace cairn
