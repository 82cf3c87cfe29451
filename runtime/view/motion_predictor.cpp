#include "runtime/view/motion_predictor.h"

#include <cmath>

#include <glm/geometric.hpp>

#include "cairn/geodesy.h"

namespace cairn {

ViewState MotionPredictor::predict(const ViewState& view, double dt_s, double ahead_s, double reach_m) {
  const glm::dvec3 position = to_geocentric(view.eye, view.height_m, view.ellipsoid);
  if (position_ && dt_s > 0) {
    const glm::dvec3 velocity = (position - *position_) / dt_s;
    velocity_ += (velocity - velocity_) * -std::expm1(-dt_s);
  }
  position_ = position;
  const glm::dvec3 step = velocity_ * ahead_s;
  if (glm::length(step) > reach_m) {
    velocity_ = glm::dvec3(0);
    return view;
  }
  const Geodetic there = to_geodetic(position + step, view.ellipsoid);
  ViewState ahead = view;
  ahead.eye = there.place;
  ahead.height_m = there.height_m;
  return ahead;
}

}  // namespace cairn
