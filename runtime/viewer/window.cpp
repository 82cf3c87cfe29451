#include "runtime/viewer/window.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <ostream>
#include <string>

#include <epoxy/gl.h>

#include "runtime/flight/camera_text.h"
// GLFW comes after epoxy, which declares OpenGL.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "runtime/viewer/camera_controls.h"
#include "runtime/viewer/display.h"
#include "runtime/viewer/flight_recorder.h"
#include "runtime/viewer/numbered_file.h"
#include "runtime/viewer/panel.h"
#include "runtime/viewer/png_file.h"
#include "runtime/viewer/scene.h"
#include "runtime/viewer/user_input.h"

namespace cairn::viewer {
namespace {

constexpr double kLongestFrame = 0.1;  // seconds that a stall may move the eye

class Session {
 public:
  Session(const Options& options, Scene scene, FrameLook look, ViewState view, const SunTime& sun,
          Display& display, std::ostream& messages)
      : scene_(std::move(scene)),
        look_(look),
        view_(view),
        display_(display),
        messages_(messages),
        samples_(options.samples) {
    panel_.sun = sun;
    panel_.tint = options.tint;
    panel_.heights = height_range(scene_.pack());
    panel_.go_to = {view.eye.lon, view.eye.lat, view.height_m};
  }

  Status run() {
    double last = glfwGetTime();
    while (!glfwWindowShouldClose(display_.window())) {
      glfwPollEvents();
      const double now = glfwGetTime();
      const double dt = now - last;
      last = now;
      panel_.frame_ms[static_cast<std::size_t>(panel_.frame_index)] = static_cast<float>(dt * 1000);
      panel_.frame_index = (panel_.frame_index + 1) % static_cast<int>(panel_.frame_ms.size());
      int width = 0, height = 0;
      glfwGetFramebufferSize(display_.window(), &width, &height);
      // Minimised, some systems say a size of 0 and others the one from before.
      if (width < 1 || height < 1 || glfwGetWindowAttrib(display_.window(), GLFW_ICONIFIED)) {
        glfwWaitEventsTimeout(0.1);
        display_.take_key_presses();
        continue;
      }
      const Status drawn = frame({width, height}, dt);
      if (!drawn) return drawn;
    }
    return {};
  }

 private:
  Status frame(Size size, double since_last_s) {
    const double dt_s = std::min(since_last_s, kLongestFrame);
    if (!target_ || target_->width() != size.width || target_->height() != size.height) {
      Result<gl::FrameTarget> target = gl::FrameTarget::create(size.width, size.height, samples_);
      if (!target) return target.error();
      target_ = std::move(*target);
    }
    view_.viewport_width_px = size.width;
    view_.viewport_height_px = size.height;
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    for (const KeyPress& press : display_.take_key_presses()) {
      if (!ImGui::GetIO().WantTextInput) handle_key(press);
    }
    view_ = controls_.update(view_, read_controls(dt_s), dt_s, ground_m());
    look_.to_sun = sun_direction(view_.eye, panel_.sun);
    look_.frame_s = since_last_s;
    panel_.counts = scene_.draw(view_, dt_s, look_, target_->framebuffer());
    panel_.paging = scene_.terrain().stats();
    for (const Error& error : scene_.take_errors()) {
      messages_ << error.message << std::endl;
      panel_.message = error.message;
    }
    if (ObjectEditor* editor = scene_.editor(); editor && panel_.shows_objects) edit(*editor);
    recorder_.add(view_, dt_s);
    if (takes_screenshot_) save_screenshot();
    show(size);
    return {};
  }

  void handle_key(const KeyPress& press) {
    const auto toggles = {std::pair(GLFW_KEY_F1, &panel_.shows_help), {GLFW_KEY_F2, &panel_.shows_panel},
                          {GLFW_KEY_F3, &panel_.shows_map},           {GLFW_KEY_F4, &look_.wireframe},
                          {GLFW_KEY_F5, &look_.level_colours},        {GLFW_KEY_F6, &look_.fog},
                          {GLFW_KEY_F7, &panel_.shows_objects}};
    for (const auto& [key, flag] : toggles) {
      if (press.key == key) *flag = !*flag;
    }
    if (ObjectEditor* editor = scene_.editor(); editor && panel_.shows_objects) {
      if (press.key == GLFW_KEY_DELETE) editor->remove();
      if (press.key == GLFW_KEY_Z && key_held(GLFW_KEY_LEFT_CONTROL)) editor->undo();
    }
    if (press.key == GLFW_KEY_ESCAPE) glfwSetWindowShouldClose(display_.window(), GLFW_TRUE);
    if (press.key == GLFW_KEY_F12) takes_screenshot_ = true;
    if (press.key == GLFW_KEY_T) move_sun(press.with_shift ? -1 : 1);
    if (press.key == GLFW_KEY_R) panel_.message = recorder_.toggle();
    if (press.key == GLFW_KEY_HOME) {
      view_ = start_view(scene_.pack(), view_.fov_y_deg, {view_.viewport_width_px, view_.viewport_height_px});
    }
    if (press.key == GLFW_KEY_TAB) {
      const bool orbits = controls_.mode() == CameraMode::free;
      const double down = std::max(std::sin(-view_.pitch_deg * 3.14159265358979 / 180), 0.05);
      controls_.set_mode(orbits ? CameraMode::orbit : CameraMode::free, (view_.height_m - ground_m()) / down);
    }
  }

  /// What a click does, which is no drag, on the picture of this frame.
  void edit(ObjectEditor& editor) {
    if (const auto click = clicked()) {
      ViewState view = view_;
      view.ellipsoid = scene_.pack().header().body.shape;
      const glm::dvec3 eye = camera_frame(view).position;
      const glm::dvec3 direction =
          direction_at(view, click->x * view_.viewport_width_px, click->y * view_.viewport_height_px);
      editor.click(panel_.click, static_cast<std::uint16_t>(panel_.model), eye, direction,
                   scene_.pick(eye, direction));
    }
    draw_object_editor(panel_, editor);
  }

  void move_sun(double hours) {
    if (panel_.sun.utc_s) {
      *panel_.sun.utc_s += 3600 * hours;
    } else {
      panel_.sun.hour = std::fmod(panel_.sun.hour + 24 + hours, 24.0);
    }
  }

  double ground_m() const { return scene_.list() ? scene_.ground_m(view_.eye) : 0; }

  void save_screenshot() {
    takes_screenshot_ = false;
    const Result<NumberedFile> file = create_numbered("cairn", "png", saved_ + 1);
    if (!file) {
      panel_.message = file.error().message;
      return;
    }
    saved_ = file->number;
    const Status written = write_png(*file, target_->read());
    panel_.message = written ? "saved " + file->name : written.error().message;
  }

  void show(Size size) {
    if (const auto place = draw_panel(panel_, look_, view_, scene_.list())) {
      view_.eye = {std::remainder((*place)[0], 360.0), std::clamp((*place)[1], -90.0, 90.0)};
      view_.height_m = (*place)[2];
    }
    ImGui::Render();
    const GLuint resolved = target_->resolve(GL_COLOR_BUFFER_BIT);
    glDisable(GL_FRAMEBUFFER_SRGB);  // the frame's bytes are sRGB already
    glBlitNamedFramebuffer(resolved, 0, 0, 0, size.width, size.height, 0, 0, size.width, size.height,
                           GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glfwSwapBuffers(display_.window());
  }

  Scene scene_;
  FrameLook look_;
  ViewState view_;
  Display& display_;
  std::ostream& messages_;
  CameraControls controls_;
  PanelState panel_;
  int samples_;
  std::optional<gl::FrameTarget> target_;
  FlightRecorder recorder_;
  int saved_ = 0;  // the number of the last screenshot
  bool takes_screenshot_ = false;
};

}  // namespace

Status run_window(const Options& options, std::ostream& messages) {
  const Result<Size> size = parse_size(options.size);
  if (!size) return size.error();
  Result<std::unique_ptr<Display>> display = Display::open(*size);
  if (!display) return display.error();
  Result<Scene> scene = Scene::open(options);
  if (!scene) return scene.error();
  const Result<FrameLook> look = look_of(options, scene->pack());
  if (!look) return look.error();
  const Result<SunTime> sun = sun_time_of(options, scene->pack());
  if (!sun) return sun.error();
  const Result<ViewState> view = view_of(options, scene->pack(), *size);
  if (!view) return view.error();
  return Session(options, std::move(*scene), *look, *view, *sun, **display, messages).run();
}

}  // namespace cairn::viewer
