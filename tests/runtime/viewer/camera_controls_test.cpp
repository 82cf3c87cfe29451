#include "runtime/viewer/camera_controls.h"

#include <cmath>
#include <fstream>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "runtime/flight/flight.h"
#include "cairn/geodesy.h"
#include "tests/support/test_data.h"

namespace cairn::viewer {
namespace {

ViewState view_at(LonLat eye, double height, double heading, double pitch) {
  ViewState view;
  view.eye = eye;
  view.height_m = height;
  view.heading_deg = heading;
  view.pitch_deg = pitch;
  return view;
}

}  // namespace

TEST_CASE("flying north over the pole goes on southwards on the other meridian") {
  CameraControls controls;
  ViewState view = view_at({20, 89.99}, 1000, 0, 0);
  ControlInput input;
  input.ahead = 1;
  for (int i = 0; i < 40; ++i) view = controls.update(view, input, 0.1, 0);
  CHECK(view.eye.lat < 90);
  CHECK(std::remainder(view.eye.lon - 200, 360.0) == Approx(0).margin(0.01));
  CHECK(std::abs(std::remainder(view.heading_deg - 180, 360.0)) < 0.01);
}

TEST_CASE("the eye stays above the ground however it is steered") {
  CameraControls controls;
  ViewState view = view_at({20, 40}, 700, 0, -80);
  ControlInput input;
  input.ahead = 1;
  input.speed = 4;
  for (int i = 0; i < 200; ++i) view = controls.update(view, input, 0.1, 500);
  CHECK(view.height_m >= 500 + kClearance);
  input.zoom_steps = 50;
  view = controls.update(view, input, 0.1, 500);
  CHECK(view.height_m >= 500 + kClearance);
}

TEST_CASE("orbiting keeps the place in the middle of the picture where it is") {
  CameraControls controls;
  controls.set_mode(CameraMode::orbit, 5000);
  ViewState view = view_at({20, 40}, 4000, 30, -40);
  const auto middle = [](const ViewState& v, double distance) {
    const CameraFrame camera = camera_frame(v);
    return camera.position + camera.forward * distance;
  };
  const glm::dvec3 place = middle(view, 5000);
  ControlInput input;
  input.turn_deg = 7;
  input.tilt_deg = -0.5;
  for (int i = 0; i < 20; ++i) view = controls.update(view, input, 0.016, 0);
  CHECK(glm::length(middle(view, 5000) - place) < 0.01);
  CHECK(std::abs(std::remainder(view.heading_deg - 170, 360.0)) < 0.5);
}

TEST_CASE("a flight is read as it was written, and turns the short way") {
  test::TempDir dir;
  Flight flight;
  flight.keys = {{0, view_at({179, 10}, 1000, 350, -10)}, {2, view_at({-179, 12}, 100, 10, -20)}};
  const auto path = dir.path() / "flight.json";
  std::ofstream(path) << to_json(flight);
  const Result<Flight> read = read_flight(path);
  REQUIRE(read.ok());
  CHECK(read->frame_count() == 61);
  const ViewState half = read->at(1);
  CHECK(half.eye.lon == Approx(180));
  CHECK(half.eye.lat == Approx(11));
  CHECK(half.heading_deg == Approx(360));
  CHECK(half.height_m > 100);
  CHECK(half.height_m < 550);
  CHECK(read->at(2).height_m == Approx(100));
}

TEST_CASE("a flight with a field missing, out of range or out of order is refused by name") {
  test::TempDir dir;
  const auto path = dir.path() / "flight.json";
  const auto message = [&](const std::string& text) {
    std::ofstream(path) << text;
    const Result<Flight> read = read_flight(path);
    return read.ok() ? std::string() : read.error().message;
  };
  const std::string key = R"("lon":1,"lat":2,"height":3,"heading":4,"pitch":5})";
  CHECK(message("[") != "");
  CHECK(message("{}").find("keys") != std::string::npos);
  CHECK(message(R"({"keys":[{"time":0,"lon":1}]})").find("\"lat\"") != std::string::npos);
  CHECK(message(R"({"keys":[{"time":1,)" + key + "]}").find("ascend") != std::string::npos);
  CHECK(message(R"({"keys":[{"time":0,)" + key + R"(,{"time":0,)" + key + "]}").find("key 1") !=
        std::string::npos);
  CHECK(message(R"({"keys":[{"time":0,"lon":1,"lat":91,"height":3,"heading":4,"pitch":5}]})")
            .find("within 90") != std::string::npos);
  CHECK(message(R"({"keys":[{"time":0,)" + key + "]}") == "");
}

}  // namespace cairn::viewer
