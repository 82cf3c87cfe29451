#include "runtime/viewer/window.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <epoxy/gl.h>

#include "cairn/geodesy.h"
#include "runtime/flight/camera_text.h"
#include "runtime/gl/view_transform.h"
// GLFW comes after epoxy, which declares OpenGL.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "runtime/viewer/camera_controls.h"
#include "runtime/viewer/display.h"
#include "runtime/viewer/flight_recorder.h"
#include "runtime/viewer/ground_probe.h"
#include "runtime/viewer/ground_profile.h"
#include "runtime/viewer/numbered_file.h"
#include "runtime/viewer/panel.h"
#include "runtime/viewer/png_file.h"
#include "runtime/viewer/scene.h"
#include "runtime/viewer/settings.h"
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
        options_(options),
        own_drape_(look.drape),
        probe_(scene_.shared_pack()),
        samples_(options.samples) {
    panel_.sun = sun;
    panel_.tint = options.tint;
    panel_.heights = height_range(scene_.pack());
    panel_.go_to = {view.eye.lon, view.eye.lat, view.height_m, view.heading_deg, view.pitch_deg};
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
    const Status kept = write_settings(settings_path(), settings());
    if (!kept) messages_ << kept.error().message << std::endl;
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
    look_under_cursor();
    if (panel_.measures) measure();
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
    if (press.key == GLFW_KEY_M) panel_.measures = !panel_.measures;
    if (press.key == GLFW_KEY_HOME) {
      view_ = start_view(scene_.pack(), view_.fov_y_deg, {view_.viewport_width_px, view_.viewport_height_px});
    }
    if (press.key == GLFW_KEY_TAB) {
      const bool orbits = controls_.mode() == CameraMode::free;
      const double down = std::max(std::sin(-view_.pitch_deg * 3.14159265358979 / 180), 0.05);
      controls_.set_mode(orbits ? CameraMode::orbit : CameraMode::free, (view_.height_m - ground_m()) / down);
    }
  }

  /// The place that the picture of this frame shows; nullopt where it shows no ground.
  std::optional<LonLat> place_at(const glm::dvec2& at) {
    const int column = std::clamp(static_cast<int>(at.x * target_->width()), 0, target_->width() - 1),
              row = std::clamp(static_cast<int>(at.y * target_->height()), 0, target_->height() - 1);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, target_->resolve(GL_DEPTH_BUFFER_BIT));
    GLfloat depth = 0;
    glReadPixels(column, target_->height() - 1 - row, 1, 1, GL_DEPTH_COMPONENT, GL_FLOAT, &depth);
    if (depth <= 0) return std::nullopt;
    ViewState view = view_;
    view.ellipsoid = scene_.pack().header().body.shape;
    const CameraFrame camera = camera_frame(view);
    const glm::dvec3 direction = direction_at(view, column + 0.5, row + 0.5);
    const double along_m = gl::kNear_m / static_cast<double>(depth) / glm::dot(direction, camera.forward);
    return to_geodetic(camera.position + direction * along_m, view.ellipsoid).place;
  }

  void look_under_cursor() {
    const auto cursor = cursor_on_picture();
    const auto place = cursor ? place_at(*cursor) : std::nullopt;
    panel_.under_cursor.clear();
    if (!place) return;
    probe_.ask(*place);
    if (const auto ground = probe_.latest()) panel_.under_cursor = text_of(*ground);
  }

  /// Adds what was clicked to the measured line, draws it, and saves its profile when asked to.
  void measure() {
    if (const auto click = clicked()) {
      if (const auto place = place_at(*click)) panel_.measured.push_back(*place);
    }
    if (panel_.measured.size() != drawn_places_) {
      drawn_places_ = panel_.measured.size();
      panel_.measured_m = length_m(scene_.pack(), panel_.measured);
      Drape drape = own_drape_ ? *own_drape_ : Drape{};
      if (drawn_places_ > 0) drape.lines.push_back({panel_.measured, {1, 1, 1}, 3});
      look_.drape = std::make_shared<const Drape>(std::move(drape));
    }
    if (std::exchange(panel_.saves_profile, false)) save_profile();
  }

  void save_profile() {
    const auto rows = ground_profile(scene_.pack(), panel_.measured);
    const auto file = rows ? create_numbered("profile", "csv", 1) : Result<NumberedFile>(rows.error());
    if (!file) {
      panel_.message = file.error().message;
      return;
    }
    const std::string csv = to_csv(*rows);
    const bool is_written = std::fwrite(csv.data(), 1, csv.size(), file->file.get()) == csv.size() &&
                            std::fflush(file->file.get()) == 0;
    panel_.message =
        is_written ? "saved " + file->name : file->name + ": expected to write it, found that it cannot be";
  }

  /// What the next window begins with.
  Options settings() const {
    Options o = options_;
    o.tint = panel_.tint;
    o.imagery = look_.imagery;
    o.exposure_ev = look_.exposure_ev;
    o.sea_m = look_.sea_m;
    o.contours_m = look_.contours_m;
    o.slopes = look_.slope_colours;
    o.no_shadows = !look_.shadows;
    o.no_fog = !look_.fog;
    o.tolerance_px = look_.tolerance_px;
    o.hour = panel_.sun.hour;
    return o;
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
      view_.heading_deg = std::remainder((*place)[3], 360.0);
      view_.pitch_deg = std::clamp((*place)[4], -90.0, 90.0);
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
  const Options& options_;
  std::shared_ptr<const Drape> own_drape_;  // of the command line
  GroundProbe probe_;
  std::size_t drawn_places_ = 0;  // of the measured line
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
