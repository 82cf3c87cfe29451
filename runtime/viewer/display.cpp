#include "runtime/viewer/display.h"

#include <string>
#include <utility>

#include <epoxy/gl.h>
// GLFW comes after epoxy, which declares OpenGL.
#include <GLFW/glfw3.h>
#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

namespace cairn::viewer {
namespace {

Error no_display() {
  const char* reason = nullptr;
  glfwGetError(&reason);
  return failed(std::string("window: expected a display with OpenGL 4.5, found none (") +
                (reason ? reason : "GLFW gives no reason") + "); --screenshot works without one");
}

}  // namespace

Result<std::unique_ptr<Display>> Display::open(Size size) {
  if (!glfwInit()) return no_display();
  auto display = std::unique_ptr<Display>(new Display);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  display->window_ = glfwCreateWindow(size.width, size.height, "cairn", nullptr, nullptr);
  if (!display->window_) return no_display();
  glfwMakeContextCurrent(display->window_);
  glfwSwapInterval(1);
  glfwSetWindowUserPointer(display->window_, display.get());
  glfwSetKeyCallback(display->window_, on_key);  // ImGui's own, set below, calls it
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;
  ImGui_ImplGlfw_InitForOpenGL(display->window_, true);
  ImGui_ImplOpenGL3_Init("#version 450 core");
  return display;
}

void Display::on_key(GLFWwindow* window, int key, int, int action, int modifiers) {
  if (action != GLFW_PRESS) return;
  auto* display = static_cast<Display*>(glfwGetWindowUserPointer(window));
  display->presses_.push_back({key, (modifiers & GLFW_MOD_SHIFT) != 0});
}

std::vector<KeyPress> Display::take_key_presses() {
  return std::exchange(presses_, {});
}

Display::~Display() {
  if (window_) {
    ImGui_ImplOpenGL3_Shutdown();
    ImGui_ImplGlfw_Shutdown();
    ImGui::DestroyContext();
    glfwDestroyWindow(window_);
  }
  glfwTerminate();
}

}  // namespace cairn::viewer
