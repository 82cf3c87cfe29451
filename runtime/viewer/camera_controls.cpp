#include "runtime/viewer/camera_controls.h"

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"

namespace cairn::viewer {
namespace {

constexpr double kSteepest = 89.9;  // degrees: straight down has no heading
constexpr double kZoomStep = 0.85;  // of the distance, a step of the wheel
constexpr double kFarthest_m = 1e8;
constexpr double kSlowest_m = 2;  // the speed of something so far above the ground

double clamped_pitch(double pitch) {
  return std::clamp(pitch, -kSteepest, kSteepest);
}

}  // namespace

ViewState view_from(const ViewState& view, const glm::dvec3& position, const glm::dvec3& forward) {
  ViewState moved = view;
  const Geodetic eye = to_geodetic(position, view.ellipsoid);
  moved.eye = eye.place;
  moved.height_m = eye.height_m;
  const LocalFrame local = local_frame(eye.place);
  const double east = glm::dot(forward, local.east), north = glm::dot(forward, local.north);
  moved.heading_deg = glm::degrees(std::atan2(east, north));
  moved.pitch_deg =
      clamped_pitch(glm::degrees(std::atan2(glm::dot(forward, local.up), std::hypot(east, north))));
  return moved;
}

void CameraControls::set_mode(CameraMode mode, double ahead_m) {
  mode_ = mode;
  pivot_distance_m_ = std::clamp(ahead_m, kSlowest_m, kFarthest_m);
}

ViewState CameraControls::update(const ViewState& view, const ControlInput& input, double dt_s,
                                 double ground_m) {
  ViewState moved = mode_ == CameraMode::free ? fly(view, input, dt_s, ground_m) : orbit(view, input, dt_s);
  moved.height_m = std::clamp(moved.height_m, ground_m + kClearance, kFarthest_m);
  return moved;
}

ViewState CameraControls::fly(ViewState view, const ControlInput& input, double dt_s, double ground_m) const {
  view.heading_deg = std::remainder(view.heading_deg + input.turn_deg, 360.0);
  view.pitch_deg = clamped_pitch(view.pitch_deg + input.tilt_deg);
  const double above = std::max(view.height_m - ground_m, kSlowest_m);
  const double step = above * input.speed * dt_s;
  const CameraFrame camera = camera_frame(view);
  const glm::dvec3 up = local_frame(view.eye).up;
  glm::dvec3 move = (camera.forward * input.ahead + camera.right * input.aside + up * input.climb) * step;
  move += camera.forward * (above * (1 - std::pow(kZoomStep, input.zoom_steps)));
  if (glm::dot(move, move) == 0) return view;
  return view_from(view, camera.position + move, camera.forward);
}

ViewState CameraControls::orbit(const ViewState& view, const ControlInput& input, double dt_s) {
  const CameraFrame camera = camera_frame(view);
  const glm::dvec3 pivot = camera.position + camera.forward * pivot_distance_m_;
  ViewState from_pivot = view_from(view, pivot, camera.forward);
  const double step = pivot_distance_m_ * input.speed * dt_s;
  from_pivot.heading_deg += input.turn_deg;
  from_pivot.pitch_deg = clamped_pitch(std::min(from_pivot.pitch_deg + input.tilt_deg, -1.0));
  const double nearer = std::pow(kZoomStep, input.zoom_steps) * std::exp(-input.climb * dt_s);
  pivot_distance_m_ = std::clamp(pivot_distance_m_ * nearer, kSlowest_m, kFarthest_m);

  const LocalFrame local = local_frame(from_pivot.eye);
  const double heading = glm::radians(from_pivot.heading_deg);
  const glm::dvec3 ahead = std::sin(heading) * local.east + std::cos(heading) * local.north;
  const glm::dvec3 right = std::cos(heading) * local.east - std::sin(heading) * local.north;
  const glm::dvec3 forward = camera_frame(from_pivot).forward;
  const glm::dvec3 place = pivot + (ahead * input.ahead + right * input.aside) * step;
  return view_from(view, place - forward * pivot_distance_m_, forward);
}

}  // namespace cairn::viewer
