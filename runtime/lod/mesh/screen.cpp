#include "runtime/lod/mesh/screen.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"

namespace cairn {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

}  // namespace

Screen::Screen(const ViewState& view) : camera_(camera_frame(view)) {
  const double half_height = std::tan(glm::radians(view.fov_y_deg) / 2);
  const double half_width = half_height * view.viewport_width_px / view.viewport_height_px;
  focal_px_ = view.viewport_height_px / (2 * half_height);
  corner_cosine_ = 1 / std::hypot(1.0, half_width, half_height);
}

double Screen::bound_px(double error_m, const glm::dvec3& centre, double radius_m) const {
  if (error_m <= 0) return 0;
  const glm::dvec3 to = centre - camera_.position;
  const double distance = glm::length(to);
  const double along = glm::dot(to, camera_.forward) - radius_m;
  const double z = std::max(along, (distance - radius_m) * corner_cosine_);
  if (z <= error_m) return kInfinite;
  const double slant = std::min(1 / corner_cosine_, (distance + radius_m) / z);  // r / z
  return focal_px_ * error_m * slant / (z - error_m);
}

glm::dvec3 to_geocentric(const LatticePoint& point, double height_m, const Ellipsoid& ellipsoid) {
  return to_geocentric(place_of(point), height_m, ellipsoid);
}

}  // namespace cairn
