#include "runtime/viewer/window.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <ostream>
#include <string>

#include <epoxy/gl.h>
// GLFW comes after epoxy, which declares OpenGL.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

#include "runtime/geodesy.h"
#include "runtime/viewer/camera_controls.h"
#include "runtime/viewer/flight.h"
#include "runtime/viewer/panel.h"
#include "runtime/viewer/png_file.h"
#include "runtime/viewer/scene.h"

namespace cairn::viewer {
namespace {

constexpr double kDegreesPerPixel = 0.15;
constexpr double kDegreesPerSecond = 90;  // of the right stick
constexpr double kLongestFrame = 0.1;     // seconds that a stall may move the eye
constexpr float kDeadZone = 0.15f;

/// GLFW, a window with a context, and ImGui in it, taken down in the reverse order.
class Display {
 public:
  static Result<std::unique_ptr<Display>> open(Size size) {
    if (!glfwInit()) return no_display();
    auto display = std::unique_ptr<Display>(new Display);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    display->window_ = glfwCreateWindow(size.width, size.height, "cairn", nullptr, nullptr);
    if (!display->window_) return no_display();
    glfwMakeContextCurrent(display->window_);
    glfwSwapInterval(1);
    ImGui::CreateContext();
    ImGui::GetIO().IniFilename = nullptr;
    ImGui_ImplGlfw_InitForOpenGL(display->window_, true);
    ImGui_ImplOpenGL3_Init("#version 450 core");
    return display;
  }
  ~Display() {
    if (window_) {
      ImGui_ImplOpenGL3_Shutdown();
      ImGui_ImplGlfw_Shutdown();
      ImGui::DestroyContext();
      glfwDestroyWindow(window_);
    }
    glfwTerminate();
  }
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
  GLFWwindow* window() const { return window_; }

 private:
  Display() = default;
  static Error no_display() {
    const char* reason = nullptr;
    glfwGetError(&reason);
    return failed(std::string("window: expected a display with OpenGL 4.5, found none (") +
                  (reason ? reason : "GLFW gives no reason") + "); --screenshot works without one");
  }
  GLFWwindow* window_ = nullptr;
};

double stick(float value) {
  return std::abs(value) < kDeadZone ? 0 : static_cast<double>(value);
}

class Session {
 public:
  Session(const Options& options, Scene scene, gl::FrameLook look, ViewState view, GLFWwindow* window,
          std::ostream& messages)
      : scene_(std::move(scene)), look_(look), view_(view), window_(window), messages_(messages) {
    panel_.hour = options.hour;
    panel_.go_to = {view.eye.lon, view.eye.lat, view.height_m};
  }

  Status run() {
    double last = glfwGetTime();
    while (!glfwWindowShouldClose(window_)) {
      glfwPollEvents();
      const double now = glfwGetTime();
      const double dt = now - last;
      last = now;
      panel_.frame_ms[static_cast<std::size_t>(panel_.frame_index)] = static_cast<float>(dt * 1000);
      panel_.frame_index = (panel_.frame_index + 1) % static_cast<int>(panel_.frame_ms.size());
      int width = 0, height = 0;
      glfwGetFramebufferSize(window_, &width, &height);
      if (width < 1 || height < 1) {  // minimised
        glfwWaitEventsTimeout(0.1);
        continue;
      }
      const Status drawn = frame({width, height}, std::min(dt, kLongestFrame));
      if (!drawn) return drawn;
    }
    return {};
  }

 private:
  Status frame(Size size, double dt_s) {
    if (!target_ || target_->width() != size.width || target_->height() != size.height) {
      Result<gl::FrameTarget> target = gl::FrameTarget::create(size.width, size.height);
      if (!target) return target.error();
      target_ = std::move(*target);
    }
    view_.viewport_width_px = size.width;
    view_.viewport_height_px = size.height;
    ImGui_ImplOpenGL3_NewFrame();
    ImGui_ImplGlfw_NewFrame();
    ImGui::NewFrame();
    handle_keys();
    move(dt_s);
    look_.to_sun = sun_direction(view_.eye, panel_.hour);
    panel_.counts = scene_.draw(view_, dt_s, look_, target_->framebuffer());
    panel_.paging = scene_.terrain().stats();
    for (const Error& error : scene_.take_errors()) {
      messages_ << error.message << std::endl;
      panel_.message = error.message;
    }
    record(dt_s);
    if (wants_screenshot_) save_screenshot();
    show(size);
    return {};
  }

  bool pressed(int key) const { return !ImGui::GetIO().WantTextInput && ImGui::IsKeyPressed(key, false); }
  bool held(int key) const { return !ImGui::GetIO().WantTextInput && ImGui::IsKeyDown(key); }
  bool shift() const { return held(GLFW_KEY_LEFT_SHIFT) || held(GLFW_KEY_RIGHT_SHIFT); }

  void handle_keys() {
    const auto toggles = {std::pair(GLFW_KEY_F1, &panel_.shows_help), {GLFW_KEY_F2, &panel_.shows_panel},
                          {GLFW_KEY_F3, &panel_.shows_map},           {GLFW_KEY_F4, &look_.wireframe},
                          {GLFW_KEY_F5, &look_.level_colours},        {GLFW_KEY_F6, &look_.fog}};
    for (const auto& [key, flag] : toggles) {
      if (pressed(key)) *flag = !*flag;
    }
    if (pressed(GLFW_KEY_ESCAPE)) glfwSetWindowShouldClose(window_, GLFW_TRUE);
    if (pressed(GLFW_KEY_F12)) wants_screenshot_ = true;
    if (pressed(GLFW_KEY_T)) panel_.hour = std::fmod(panel_.hour + (shift() ? 23 : 1), 24.0);
    if (pressed(GLFW_KEY_R)) toggle_recording();
    if (pressed(GLFW_KEY_HOME)) {
      view_ = start_view(scene_.pack(), view_.fov_y_deg, {view_.viewport_width_px, view_.viewport_height_px});
    }
    if (pressed(GLFW_KEY_TAB)) {
      const bool orbits = controls_.mode() == CameraMode::free;
      const double down = std::max(std::sin(-view_.pitch_deg * 3.14159265358979 / 180), 0.05);
      controls_.set_mode(orbits ? CameraMode::orbit : CameraMode::free, (view_.height_m - ground_m()) / down);
    }
  }

  double ground_m() const { return scene_.list() ? scene_.ground_m(view_.eye) : 0; }

  void move(double dt_s) {
    const ImGuiIO& io = ImGui::GetIO();
    ControlInput input;
    input.ahead = held(GLFW_KEY_W) - held(GLFW_KEY_S);
    input.aside = held(GLFW_KEY_D) - held(GLFW_KEY_A);
    input.climb = held(GLFW_KEY_E) - held(GLFW_KEY_Q);
    input.speed = shift() ? 4 : 1;
    if (!io.WantCaptureMouse) {
      if (ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
        input.turn_deg = static_cast<double>(-io.MouseDelta.x) * kDegreesPerPixel;
        input.tilt_deg = static_cast<double>(io.MouseDelta.y) * kDegreesPerPixel;
      }
      input.zoom_steps = static_cast<double>(io.MouseWheel);
    }
    add_pad(input, dt_s);
    view_ = controls_.update(view_, input, dt_s, ground_m());
  }

  static void add_pad(ControlInput& input, double dt_s) {
    GLFWgamepadstate pad;
    if (!glfwGetGamepadState(GLFW_JOYSTICK_1, &pad)) return;
    input.aside += stick(pad.axes[GLFW_GAMEPAD_AXIS_LEFT_X]);
    input.ahead -= stick(pad.axes[GLFW_GAMEPAD_AXIS_LEFT_Y]);
    input.turn_deg += stick(pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_X]) * kDegreesPerSecond * dt_s;
    input.tilt_deg -= stick(pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_Y]) * kDegreesPerSecond * dt_s;
    input.climb += static_cast<double>(pad.axes[GLFW_GAMEPAD_AXIS_RIGHT_TRIGGER] -
                                       pad.axes[GLFW_GAMEPAD_AXIS_LEFT_TRIGGER]) /
                   2;
  }

  void toggle_recording() {
    if (!recording_) {
      recording_.emplace();
      recorded_s_ = 0;
      panel_.message = "recording; R ends it";
      return;
    }
    const std::string name = "flight-" + std::to_string(++saved_) + ".json";
    std::ofstream out(name, std::ios::trunc);
    out << to_json(*recording_);
    panel_.message =
        out.flush() ? "saved " + name : name + ": flight: expected to write it, found that it cannot be";
    recording_.reset();
  }

  void record(double dt_s) {
    if (!recording_) return;
    recording_->keys.push_back({recorded_s_, view_});
    recorded_s_ += std::max(dt_s, 1e-4);
  }

  void save_screenshot() {
    wants_screenshot_ = false;
    const std::string name = "cairn-" + std::to_string(++saved_) + ".png";
    const Status written = write_png(name, target_->read());
    panel_.message = written ? "saved " + name : written.error().message;
  }

  void show(Size size) {
    if (const auto place = draw_panel(panel_, look_, view_, scene_.list())) {
      view_.eye = {std::remainder((*place)[0], 360.0), std::clamp((*place)[1], -90.0, 90.0)};
      view_.height_m = (*place)[2];
    }
    ImGui::Render();
    glDisable(GL_FRAMEBUFFER_SRGB);  // the frame's bytes are sRGB already
    glBlitNamedFramebuffer(target_->framebuffer(), 0, 0, 0, size.width, size.height, 0, 0, size.width,
                           size.height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    glClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    glfwSwapBuffers(window_);
  }

  Scene scene_;
  gl::FrameLook look_;
  ViewState view_;
  GLFWwindow* window_;
  std::ostream& messages_;
  CameraControls controls_;
  PanelState panel_;
  std::optional<gl::FrameTarget> target_;
  std::optional<Flight> recording_;
  double recorded_s_ = 0;
  int saved_ = 0;
  bool wants_screenshot_ = false;
};

}  // namespace

Status run_window(const Options& options, std::ostream& messages) {
  const Result<Size> size = parse_size(options.size);
  if (!size) return size.error();
  const Result<gl::FrameLook> look = look_of(options);
  if (!look) return look.error();
  Result<std::unique_ptr<Display>> display = Display::open(*size);
  if (!display) return display.error();
  Result<Scene> scene = Scene::open(options);
  if (!scene) return scene.error();
  const Result<ViewState> view = view_of(options, scene->pack(), *size);
  if (!view) return view.error();
  return Session(options, std::move(*scene), *look, *view, (*display)->window(), messages).run();
}

}  // namespace cairn::viewer
