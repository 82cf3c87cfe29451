#pragma once

#include <memory>

#include "cairn/status.h"
#include "runtime/flight/camera_text.h"

struct GLFWwindow;

namespace cairn::viewer {

/// GLFW, a window with an OpenGL 4.5 context that is current, and ImGui in it, taken down in the reverse
/// order.
class Display {
 public:
  /// failed where there is no display or no such context.
  static Result<std::unique_ptr<Display>> open(Size size);
  ~Display();
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
  GLFWwindow* window() const { return window_; }

 private:
  Display() = default;
  GLFWwindow* window_ = nullptr;
};

}  // namespace cairn::viewer
