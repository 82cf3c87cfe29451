#include "runtime/view/screen_scale.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace cairn {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

}  // namespace

double pixels_per_radian(const ViewState& view) {
  return view.viewport_height_px / (2 * std::tan(glm::radians(view.fov_y_deg) / 2));
}

ScreenScale::ScreenScale(const ViewState& view)
    : camera_(camera_frame(view)), focal_px_(pixels_per_radian(view)) {
  const double half_height = std::tan(glm::radians(view.fov_y_deg) / 2);
  const double half_width = half_height * view.viewport_width_px / view.viewport_height_px;
  corner_cosine_ = 1 / std::hypot(1.0, half_width, half_height);
}

double ScreenScale::least_depth_m(const BoundingVolume& volume, double distance_m) const {
  double along = glm::dot(volume.centre - camera_.position, camera_.forward);
  for (const glm::dvec3& half_axis : volume.half_axes) {
    along -= std::abs(glm::dot(half_axis, camera_.forward));
  }
  return std::max(along, distance_m * corner_cosine_);
}

double ScreenScale::error_px(const BoundingVolume& volume, double error_m) const {
  if (error_m <= 0) return 0;
  const double distance = volume.distance_m(camera_.position);
  const double z = least_depth_m(volume, distance);
  if (z <= error_m) return kInfinite;
  const double across = glm::length(volume.half_axes[0] + volume.half_axes[1] + volume.half_axes[2]);
  const double farthest = glm::length(volume.centre - camera_.position) + across;
  const double slant = std::min(1 / corner_cosine_, farthest / z);  // r / z
  return focal_px_ * error_m * slant / (z - error_m);
}

double ScreenScale::length_px(const BoundingVolume& volume, double length_m) const {
  const double z = least_depth_m(volume, volume.distance_m(camera_.position));
  return z > 0 ? focal_px_ * length_m / z : kInfinite;
}

double ScreenScale::error_px_in_the_middle(const BoundingVolume& volume, double error_m) const {
  const double left = volume.distance_m(camera_.position) - error_m;
  return left > 0 ? focal_px_ * error_m / left : kInfinite;
}

}  // namespace cairn
