#include "cairn/view_state.h"

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"

namespace cairn {

CameraFrame camera_frame(const ViewState& view) {
  const LocalFrame local = local_frame(view.eye);
  const double heading = glm::radians(view.heading_deg);
  const double pitch = glm::radians(view.pitch_deg);
  const double roll = glm::radians(view.roll_deg);
  const glm::dvec3 ahead = std::cos(heading) * local.north + std::sin(heading) * local.east;
  const glm::dvec3 right = std::cos(heading) * local.east - std::sin(heading) * local.north;
  const glm::dvec3 forward = std::cos(pitch) * ahead + std::sin(pitch) * local.up;
  const glm::dvec3 up = std::cos(pitch) * local.up - std::sin(pitch) * ahead;
  return {to_geocentric(view.eye, view.height_m, view.ellipsoid),
          std::cos(roll) * right - std::sin(roll) * up, std::cos(roll) * up + std::sin(roll) * right,
          forward};
}

std::array<glm::dvec3, 5> inward_normals(const CameraFrame& camera, const ViewState& view) {
  const double top = std::tan(glm::radians(view.fov_y_deg) / 2);
  const double side = top * view.viewport_width_px / view.viewport_height_px;
  return {glm::normalize(camera.forward * side + camera.right),
          glm::normalize(camera.forward * side - camera.right),
          glm::normalize(camera.forward * top + camera.up), glm::normalize(camera.forward * top - camera.up),
          camera.forward};
}

double pixel_footprint_m(const ViewState& view, double distance_m) {
  return 2 * distance_m * std::tan(glm::radians(view.fov_y_deg) / 2) / view.viewport_height_px;
}

}  // namespace cairn
