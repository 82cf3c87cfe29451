#pragma once

#include <glm/vec3.hpp>

#include "cairn/bounding_volume.h"
#include "cairn/view_state.h"

namespace cairn {

/// Returns the pixels per radian in the middle of the viewport: its height / (2 tan(fov/2)).
double pixels_per_radian(const ViewState& view);

/// How lengths on the ground become pixels in one view. All bounds hold for every point of a volume that is
/// in the viewport, and are infinite where such a point may lie beside the eye.
class ScreenScale {
 public:
  explicit ScreenScale(const ViewState& view);

  /// Returns a bound, in pixels, on how far a point of the volume moves on the screen if it is displaced by
  /// `error_m` in any direction: f·ε·r/(z(z-ε)), with f the focal length in pixels, r the distance from the
  /// eye, and z the depth, which is at least r·cos θ, θ the angle to the viewport's corner.
  double error_px(const BoundingVolume& volume, double error_m) const;

  /// Returns a bound, in pixels, on the length across the view of a piece of ground: f·l/z.
  double length_px(const BoundingVolume& volume, double length_m) const;

  /// Returns what error_px() would be in the middle of the viewport, wherever the volume lies: what a turn of
  /// the eye may bring into view.
  double error_px_in_the_middle(const BoundingVolume& volume, double error_m) const;

 private:
  /// The least depth of a point of the volume that is in the viewport, in metres; may be negative.
  double least_depth_m(const BoundingVolume& volume, double distance_m) const;

  CameraFrame camera_;
  double focal_px_;
  double corner_cosine_;
};

}  // namespace cairn
