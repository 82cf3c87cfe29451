#pragma once

#include "cairn/view_state.h"

namespace cairn::viewer {

/// What the user's hands do in a frame, each axis from -1 to 1 unless said otherwise.
struct ControlInput {
  double ahead = 0;       ///< W and S, left stick
  double aside = 0;       ///< D and A: to the right
  double climb = 0;       ///< E and Q: up
  double speed = 1;       ///< a factor on the usual speed; > 0
  double turn_deg = 0;    ///< of a drag or the right stick, to the right, in this frame
  double tilt_deg = 0;    ///< up
  double zoom_steps = 0;  ///< of the wheel: nearer
};

enum class CameraMode { free, orbit };

/// Moves a view over the Earth. Straight ahead is straight in space, so that flying over a pole or across the
/// antimeridian is like flying anywhere else.
class CameraControls {
 public:
  CameraMode mode() const { return mode_; }
  /// Orbiting keeps to the place that the middle of the picture shows, `ahead_m` in front of the eye.
  void set_mode(CameraMode mode, double ahead_m);

  /// The view after `dt_s` seconds. `ground_m` is the ground's height below the eye: the speed follows the
  /// height above it, a full deflection covering it in a second, and the eye stays kClearance above it.
  ViewState update(const ViewState& view, const ControlInput& input, double dt_s, double ground_m);

 private:
  ViewState fly(ViewState view, const ControlInput& input, double dt_s, double ground_m) const;
  ViewState orbit(const ViewState& view, const ControlInput& input, double dt_s);

  CameraMode mode_ = CameraMode::free;
  double pivot_distance_m_ = 1000;
};

/// Metres that the eye keeps above the ground.
inline constexpr double kClearance = 1.6;

/// The same view from `position`, looking along `forward` (geocentric); what is not said is as in `view`.
ViewState view_from(const ViewState& view, const glm::dvec3& position, const glm::dvec3& forward);

}  // namespace cairn::viewer
