#pragma once

#include <algorithm>
#include <array>

#include <glm/vec3.hpp>

#include "cairn/view_state.h"
#include "runtime/view/horizon.h"

namespace cairn {

/// A sphere that contains all of the surface over a square. The centre is geocentric, in metres.
struct SquareSphere {
  glm::dvec3 centre{0};
  double radius_m = 0;
};

/// Returns the vertical errors, in metres, that triangles may have for one camera and tolerance.
///
/// Symbols: f is the focal length in pixels; P the vector from the camera to a point, z = Pz its depth along
/// the view, P⊥ its part across the view. A displacement δ of the point moves its projection by exactly
/// f|z·δ⊥ − P⊥·δz| / (z(z−δz)) pixels, which is at most f|P||δ| / (z(z−|δ|)). Let e be the error of a
/// triangle and g that of its tile, both vertical, and s the sagitta of the Earth's curvature, in any
/// direction. Then the projection moves by at most f((e+g)|z·up⊥ − P⊥·upz| + s|P|) / (z(z−e−g−s)) pixels.
/// |P×up| bounds the first length too, but is larger: it counts the part along the view.
///
/// Immutable; any thread may use it.
class ScreenErrorBudget {
 public:
  /// `lowest_m` is the lowest height of the scene. What the ellipsoid at that height occludes is invisible.
  ScreenErrorBudget(const ViewState& view, double tolerance_px, double lowest_m);

  double tolerance_px() const { return tolerance_px_; }

  /// How displacements in a region project: one of δ metres moves by at most px·δ/(depth_m − δ) pixels.
  struct ProjectedScale {
    double depth_m = 0;      ///< lower bound of the depth; 0 or below if the region may reach the camera
    double vertical_px = 0;  ///< px for a vertical displacement
    double any_px = 0;       ///< px for a displacement in any direction
    bool is_small = false;   ///< the scale varies little within the region
  };
  /// The scale for the part of a sphere that is in the viewport. `up` is the ellipsoid's normal at its
  /// centre.
  ProjectedScale scale_of(const SquareSphere& sphere, const glm::dvec3& up) const;
  ProjectedScale scale_of(const SquareSphere& sphere) const;
  /// The scale for everything in the viewport that is at least this far away.
  ProjectedScale scale_from(double distance_m) const;

  /// Returns a conservative scale for displacements of unknown direction: vertical_px = any_px.
  static ProjectedScale isotropic(ProjectedScale scale) {
    return {scale.depth_m, scale.any_px, scale.any_px, scale.is_small};
  }

  /// Returns the largest allowed vertical error e of a triangle in metres, negative if none is allowed.
  /// `tile_m` is g and `sagitta_m` is s of the class comment. Where g takes more than three quarters of what
  /// s leaves, a quarter of that is allowed nevertheless.
  double error_m(const ProjectedScale& scale, double tile_m, double sagitta_m) const {
    return error_m(headroom_of(scale), tile_m, sagitta_m);
  }
  /// What a region leaves for e, g and s: e + g <= all_m − s·per_sagitta. Computed once for many s.
  struct Headroom {
    double all_m;
    double per_sagitta;
  };
  Headroom headroom_of(const ProjectedScale& scale) const;
  static double error_m(const Headroom& headroom, double tile_m, double sagitta_m) {
    const double left = headroom.all_m - sagitta_m * headroom.per_sagitta;
    return std::max(left - tile_m, left / 4);
  }

  /// Returns false only if no part of the sphere is both in the viewport and above the horizon.
  bool may_be_visible(const SquareSphere& sphere) const;

 private:
  glm::dvec3 position_;
  glm::dvec3 forward_;
  glm::dvec3 right_;
  glm::dvec3 up_;
  std::array<glm::dvec3, 4> inward_;  ///< normals of the view frustum's sides
  Horizon horizon_;
  double focal_px_;
  double tolerance_px_;
  Ellipsoid ellipsoid_;
  double normal_tilt_;    ///< radians: how far a sphere's `up` may be from the ellipsoid's normal
  double normal_turn_m_;  ///< the normal turns by one radian over no less
  double corner_cosine_;  ///< of the angle between the view and a corner of the viewport
};

}  // namespace cairn
