#include "runtime/gl/view_transform.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"

namespace cairn::gl {

glm::dmat4 clip_from_eye(const CameraFrame& camera, const ViewState& view) {
  const double f = 1 / std::tan(glm::radians(view.fov_y_deg) / 2);
  const double aspect = static_cast<double>(view.viewport_width_px) / view.viewport_height_px;
  const glm::dvec3 right = camera.right * (f / aspect), up = camera.up * f;
  const glm::dmat4 rows{glm::dvec4(right, 0), glm::dvec4(up, 0), glm::dvec4(0, 0, 0, kNear_m),
                        glm::dvec4(camera.forward, 0)};
  return glm::transpose(rows);
}

glm::dvec4 horizon_plane(const glm::dvec3& eye, const Ellipsoid& ellipsoid) {
  // No ground is lower, or higher: Olympus Mons has 21 km.
  constexpr double kDeepest = 12000, kHighest = 25000;
  const double a = ellipsoid.semi_major_m, b = ellipsoid.semi_minor_m;
  const glm::dvec3 radii = glm::dvec3(a, a, b) - std::min(kDeepest, b / 2);
  const glm::dvec3 scaled = eye / radii;
  const double m = glm::length(scaled);
  if (m <= 1) return {0, 0, 0, 1};
  const double r = (b + kHighest) / radii.z;
  const double seen = 1 / m - std::sqrt(1 - 1 / (m * m)) * std::sqrt(r * r - 1);
  return {scaled / m / radii, m - seen};
}

}  // namespace cairn::gl
