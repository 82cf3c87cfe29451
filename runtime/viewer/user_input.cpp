#include "runtime/viewer/user_input.h"

#include <cmath>

#include <epoxy/gl.h>
// GLFW comes after epoxy, which declares OpenGL.
#include <GLFW/glfw3.h>
#include <imgui.h>

namespace cairn::viewer {
namespace {

constexpr double kDegreesPerPixel = 0.15;
constexpr double kDegreesPerSecond = 90;  // of the right stick
constexpr float kDeadZone = 0.15f;

double stick(float value) {
  return std::abs(value) < kDeadZone ? 0 : static_cast<double>(value);
}

void add_pad(ControlInput& input, double dt_s) {
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

}  // namespace

bool key_held(int key) {
  return !ImGui::GetIO().WantTextInput && ImGui::IsKeyDown(key);
}

bool shift_held() {
  return key_held(GLFW_KEY_LEFT_SHIFT) || key_held(GLFW_KEY_RIGHT_SHIFT);
}

std::optional<glm::dvec2> clicked() {
  const ImGuiIO& io = ImGui::GetIO();
  if (io.WantCaptureMouse || !ImGui::IsMouseReleased(ImGuiMouseButton_Left)) return std::nullopt;
  constexpr float kDrag = 4;  // pixels
  const float dx = io.MousePos.x - io.MouseClickedPos[0].x, dy = io.MousePos.y - io.MouseClickedPos[0].y;
  if (std::hypot(dx, dy) > kDrag) return std::nullopt;
  return glm::dvec2(static_cast<double>(io.MousePos.x / io.DisplaySize.x),
                    static_cast<double>(io.MousePos.y / io.DisplaySize.y));
}

std::optional<glm::dvec2> cursor_on_picture() {
  const ImGuiIO& io = ImGui::GetIO();
  const glm::dvec2 at(static_cast<double>(io.MousePos.x / io.DisplaySize.x),
                      static_cast<double>(io.MousePos.y / io.DisplaySize.y));
  const bool is_inside = at.x >= 0 && at.y >= 0 && at.x < 1 && at.y < 1;  // false where there is no mouse
  if (io.WantCaptureMouse || !is_inside) return std::nullopt;
  return at;
}

ControlInput read_controls(double dt_s) {
  const ImGuiIO& io = ImGui::GetIO();
  ControlInput input;
  input.ahead = key_held(GLFW_KEY_W) - key_held(GLFW_KEY_S);
  input.aside = key_held(GLFW_KEY_D) - key_held(GLFW_KEY_A);
  input.climb = key_held(GLFW_KEY_E) - key_held(GLFW_KEY_Q);
  input.speed = shift_held() ? 4 : 1;
  if (!io.WantCaptureMouse) {
    if (ImGui::IsMouseDown(ImGuiMouseButton_Left)) {
      input.turn_deg = static_cast<double>(-io.MouseDelta.x) * kDegreesPerPixel;
      input.tilt_deg = static_cast<double>(io.MouseDelta.y) * kDegreesPerPixel;
    }
    input.zoom_steps = static_cast<double>(io.MouseWheel);
  }
  add_pad(input, dt_s);
  return input;
}

}  // namespace cairn::viewer
