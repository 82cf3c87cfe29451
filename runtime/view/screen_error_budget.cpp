#include "runtime/view/screen_error_budget.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>

#include "cairn/geodesy.h"
#include "cairn/view_state.h"
#include "runtime/view/screen_scale.h"

namespace cairn {
namespace {

/// Bound, in radians, of the angle between the ellipsoid's normal under a point and the gradient of the
/// ellipsoid's equation at the point. The angle is at most e²h/2a; twice that is taken for |h| <= 20 km.
double normal_tilt(const Ellipsoid& e) {
  constexpr double kHighest_m = 20e3;
  const double ratio = e.semi_minor_m / e.semi_major_m;
  return (1 - ratio * ratio) * kHighest_m / e.semi_major_m;
}

/// Over a distance d the ellipsoid's normal turns by at most d divided by this: the least radius of
/// curvature, less 15 km for places below the ellipsoid.
double normal_turn_m(const Ellipsoid& e) {
  constexpr double kDeepest_m = 15e3;
  return std::max(least_curvature_m(e) - kDeepest_m, least_curvature_m(e) / 2);
}

/// Unit vector along the gradient of the ellipsoid's equation at the point: up, to within normal_tilt().
glm::dvec3 up_at(const glm::dvec3& point, const Ellipsoid& ellipsoid) {
  const double a = ellipsoid.semi_major_m, b = ellipsoid.semi_minor_m;
  return glm::normalize(point / glm::dvec3(a * a, a * a, b * b));
}

/// A sphere is small if its radius is at most this fraction of its depth. The scale at its nearest point is
/// then at most 1/31 larger than at its centre.
constexpr double kSmall = 1.0 / 32;

}  // namespace

ScreenErrorBudget::ScreenErrorBudget(const ViewState& view, double tolerance_px, double lowest_m)
    : horizon_(camera_frame(view).position, Occluder(lowest_m, view.ellipsoid)),
      tolerance_px_(tolerance_px),
      ellipsoid_(view.ellipsoid),
      normal_tilt_(normal_tilt(view.ellipsoid)),
      normal_turn_m_(normal_turn_m(view.ellipsoid)) {
  const CameraFrame camera = camera_frame(view);
  position_ = camera.position;
  forward_ = camera.forward;
  right_ = camera.right;
  up_ = camera.up;
  const double high = std::tan(glm::radians(view.fov_y_deg) / 2);
  const double wide = high * view.viewport_width_px / view.viewport_height_px;
  inward_ = {glm::normalize(camera.forward * wide + camera.right),
             glm::normalize(camera.forward * wide - camera.right),
             glm::normalize(camera.forward * high + camera.up),
             glm::normalize(camera.forward * high - camera.up)};
  focal_px_ = pixels_per_radian(view);
  corner_cosine_ = 1 / std::hypot(1.0, high, wide);
}

ScreenErrorBudget::ProjectedScale ScreenErrorBudget::scale_of(const SquareSphere& sphere) const {
  return scale_of(sphere, up_at(sphere.centre, ellipsoid_));
}

ScreenErrorBudget::ProjectedScale ScreenErrorBudget::scale_of(const SquareSphere& sphere,
                                                              const glm::dvec3& up) const {
  const glm::dvec3 to = sphere.centre - position_;
  const double distance = glm::length(to), radius = sphere.radius_m, far = distance + radius;
  ProjectedScale scale;
  scale.depth_m = std::max(glm::dot(to, forward_) - radius, (distance - radius) * corner_cosine_);
  if (scale.depth_m <= 0) return scale;
  const double z = glm::dot(to, forward_), up_z = glm::dot(up, forward_);
  const glm::dvec2 across{z * glm::dot(up, right_) - glm::dot(to, right_) * up_z,
                          z * glm::dot(up, up_) - glm::dot(to, up_) * up_z};
  const double beside = glm::length(across) + radius + far * (radius / normal_turn_m_ + normal_tilt_);
  scale.any_px = focal_px_ * std::min(1 / corner_cosine_, far / scale.depth_m);
  scale.vertical_px = std::min(scale.any_px, focal_px_ * beside / scale.depth_m);
  scale.is_small = radius <= kSmall * scale.depth_m;
  return scale;
}

ScreenErrorBudget::ProjectedScale ScreenErrorBudget::scale_from(double distance_m) const {
  const double px = focal_px_ / corner_cosine_;
  return {distance_m * corner_cosine_, px, px, false};
}

ScreenErrorBudget::Headroom ScreenErrorBudget::headroom_of(const ProjectedScale& scale) const {
  if (scale.depth_m <= 0) return {-1, 0};
  const double per_px = 1 / (scale.vertical_px + tolerance_px_);
  return {tolerance_px_ * scale.depth_m * per_px, (scale.any_px + tolerance_px_) * per_px};
}

bool ScreenErrorBudget::may_be_visible(const SquareSphere& sphere) const {
  const glm::dvec3 to = sphere.centre - position_;
  return std::all_of(inward_.begin(), inward_.end(),
                     [&](const glm::dvec3& n) { return glm::dot(n, to) >= -sphere.radius_m; }) &&
         !horizon_.hides(sphere.centre, sphere.radius_m);
}

}  // namespace cairn
