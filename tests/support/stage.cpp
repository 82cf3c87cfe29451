#include "tests/support/stage.h"

#include <cmath>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"

namespace cairn::test {

Stage::Stage(const std::filesystem::path& pack, int width, int height)
    : context_(gl::HeadlessContext::create()), target_(gl::FrameTarget::create(width, height)) {
  REQUIRE(context_.ok());
  REQUIRE(target_.ok());
  viewer::Options options;
  options.pack = pack;
  Result<viewer::Scene> scene = viewer::Scene::open(options);
  if (!scene) FAIL(scene.error().message);
  scene_ = std::move(*scene);
  scene_->take_errors();  // which layers the pack has not
  look.hole_colour = glm::vec3(1, 0, 1);
}

void Stage::draw(const ViewState& view) {
  scene_->set_tolerance_px(look.tolerance_px);
  scene_->load_all(view);
  scene_->cut();
  draw_now(view, 0);
}

void Stage::draw_now(const ViewState& view, double dt_s) {
  scene_->draw(view, dt_s, look, target_->framebuffer());
}

int Stage::holes() const {
  const gl::Picture picture = target_->read();
  int count = 0;
  for (std::size_t i = 0; i < picture.rgb.size(); i += 3) {
    count += picture.rgb[i] == 255 && picture.rgb[i + 1] == 0 && picture.rgb[i + 2] == 255;
  }
  return count;
}

ViewState view_at(LonLat eye, double height_m, double heading_deg, double pitch_deg) {
  ViewState view;
  view.eye = eye;
  view.height_m = height_m;
  view.heading_deg = heading_deg;
  view.pitch_deg = pitch_deg;
  view.fov_y_deg = 45;
  view.viewport_width_px = 160;
  view.viewport_height_px = 120;
  return view;
}

glm::dvec3 sun_at(LonLat place, double azimuth_deg, double height_deg) {
  const LocalFrame frame = local_frame(place);
  const double a = glm::radians(azimuth_deg), h = glm::radians(height_deg);
  return (frame.north * std::cos(a) + frame.east * std::sin(a)) * std::cos(h) + frame.up * std::sin(h);
}

PicturePoint project(const ViewState& view, const glm::dvec3& point) {
  const CameraFrame camera = camera_frame(view);
  const glm::dvec3 to = point - camera.position;
  const double depth = glm::dot(to, camera.forward);
  const double scale = view.viewport_height_px / 2.0 / std::tan(glm::radians(view.fov_y_deg) / 2) / depth;
  return {view.viewport_width_px / 2.0 + glm::dot(to, camera.right) * scale,
          view.viewport_height_px / 2.0 - glm::dot(to, camera.up) * scale, depth};
}

glm::dvec3 shown_at(const ViewState& view, double x, double y, double depth) {
  const CameraFrame camera = camera_frame(view);
  const double unit = 2 * std::tan(glm::radians(view.fov_y_deg) / 2) / view.viewport_height_px;
  const glm::dvec3 ray = camera.forward + camera.right * ((x - view.viewport_width_px / 2.0) * unit) -
                         camera.up * ((y - view.viewport_height_px / 2.0) * unit);
  return camera.position + ray * (gl::kNear_m / depth);
}

}  // namespace cairn::test
