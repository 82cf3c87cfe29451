#pragma once

#include <glm/vec3.hpp>

#include "cairn/view_state.h"
#include "runtime/view/sample_lattice.h"
#include "runtime/view/screen_scale.h"
#include "runtime/view/view_frustum.h"

namespace cairn {

/// Converts distances to pixels of a view.
///
/// A screen error is the distance in pixels between the projections of a sample and of the mesh's point at
/// the sample's longitude and latitude, where the triangle is linear in longitude and latitude. Both are
/// projected from geocentric coordinates, so the body's curvature under a large triangle counts.
class Screen {
 public:
  explicit Screen(const ViewState& view)
      : camera_(camera_frame(view)), focal_px_(cairn::pixels_per_radian(view)) {}

  const CameraFrame& camera() const { return camera_; }
  /// In the middle of the viewport: its height / (2 tan(fov/2)).
  double pixels_per_radian() const { return focal_px_; }

 private:
  CameraFrame camera_;
  double focal_px_;
};

/// Returns geocentric metres.
glm::dvec3 to_geocentric(const LatticePoint& point, double height_m, const Ellipsoid& ellipsoid = {});

}  // namespace cairn
