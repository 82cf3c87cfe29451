#pragma once

#include <glm/vec3.hpp>

#include "runtime/view/sample_lattice.h"
#include "runtime/view/view_frustum.h"
#include "cairn/view_state.h"

namespace cairn {

/// Pixels on the picture of a view. A screen error is the distance between the projections of a sample and of
/// the mesh's point at the same longitude and latitude (interpolated on the triangle in these), all in
/// geocentric coordinates, so that the Earth's curvature under a large triangle counts.
class Screen {
 public:
  explicit Screen(const ViewState& view);

  const CameraFrame& camera() const { return camera_; }
  double pixels_per_radian() const { return focal_px_; }  ///< in the middle: picture height / (2 tan(fov/2))

  /// How far, in pixels, any point of a sphere that is in the picture can move if it is displaced by error_m
  /// in any direction: by f·ε·r/(z(z-ε)) at most, r the distance from the eye, z that along the view, which
  /// is at least r·cos θ, θ the angle to the picture's corner. Infinite where a point may come beside the
  /// eye.
  double bound_px(double error_m, const glm::dvec3& centre, double radius_m) const;

 private:
  CameraFrame camera_;
  double focal_px_;
  double corner_cosine_;
};

/// Geocentric metres.
glm::dvec3 to_geocentric(const LatticePoint& point, double height_m);

}  // namespace cairn
