#include "runtime/view/motion_predictor.h"

#include <cmath>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "cairn/geodesy.h"

namespace cairn {
namespace {

constexpr double kFrame_s = 1.0 / 60;
constexpr double kFar_m = 1e6;

ViewState at(const glm::dvec3& geocentric) {
  const Geodetic there = to_geodetic(geocentric);
  ViewState view;
  view.eye = there.place;
  view.height_m = there.height_m;
  return view;
}

glm::dvec3 position_of(const ViewState& view) {
  return to_geocentric(view.eye, view.height_m);
}

/// Where the predictor expects the camera 2 s after it has flown straight for so long.
struct Flight {
  glm::dvec3 from = to_geocentric({179.999, 36.7}, 3000);
  glm::dvec3 velocity = 200.0 * local_frame({179.999, 36.7}).east;
  double shake_m = 0;

  glm::dvec3 expected_ahead(MotionPredictor& predictor, double seconds) const {
    glm::dvec3 ahead{0};
    const int frames = static_cast<int>(seconds / kFrame_s);
    for (int i = 0; i <= frames; ++i) {
      const double shake = shake_m * (i % 2 == 0 ? 1 : -1);
      const glm::dvec3 now = from + velocity * (i * kFrame_s) + shake * glm::normalize(from);
      ahead = position_of(predictor.predict(at(now), kFrame_s, 2, kFar_m));
    }
    return ahead - (from + velocity * (frames * kFrame_s));
  }
};

}  // namespace

TEST_CASE("a camera that flies straight is expected where it will be, across 180° too") {
  MotionPredictor predictor;
  const glm::dvec3 step = Flight{}.expected_ahead(predictor, 8);
  CHECK(glm::length(step - 2.0 * Flight{}.velocity) < 0.001 * glm::length(step));
}

TEST_CASE("a velocity is an average over a second: after one it is 63 % of a new one") {
  MotionPredictor predictor;
  const glm::dvec3 step = Flight{}.expected_ahead(predictor, 1);
  CHECK(glm::length(step) / 400 == Approx(-std::expm1(-1.0)).margin(0.02));
}

TEST_CASE("a camera that shakes by a metre is expected within a metre and a half of where it is") {
  MotionPredictor predictor;
  Flight flight;
  flight.velocity = {0, 0, 0};
  flight.shake_m = 0.5;
  CHECK(glm::length(flight.expected_ahead(predictor, 8)) < 1.5);
}

TEST_CASE("a jump is no motion: the view stays, also in the frames after it") {
  MotionPredictor predictor;
  (void)Flight{}.expected_ahead(predictor, 2);
  ViewState elsewhere;
  elsewhere.eye = {-60, -10};
  elsewhere.height_m = 500;
  const ViewState after = predictor.predict(elsewhere, kFrame_s, 2, 100'000);
  CHECK(glm::length(position_of(after) - position_of(elsewhere)) == 0);
  const ViewState later = predictor.predict(elsewhere, kFrame_s, 2, 100'000);
  CHECK(glm::length(position_of(later) - position_of(elsewhere)) < 1e-6);
}

TEST_CASE("frames without a time between them change nothing") {
  MotionPredictor predictor;
  ViewState view = at(Flight{}.from);
  for (int i = 0; i < 3; ++i) {
    const ViewState ahead = predictor.predict(view, 0, 2, kFar_m);
    CHECK(glm::length(position_of(ahead) - position_of(view)) < 1e-6);
    view = at(position_of(view) + Flight{}.velocity);
  }
}

}  // namespace cairn
