#pragma once

#include <memory>
#include <vector>

#include "cairn/status.h"
#include "runtime/flight/camera_text.h"

struct GLFWwindow;

namespace cairn::viewer {

/// A key, as GLFW names it, that went down.
struct KeyPress {
  int key = 0;
  bool with_shift = false;
};

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

  /// Returns the keys that went down since the last call, in their order, also those that were let go since.
  std::vector<KeyPress> take_key_presses();

 private:
  Display() = default;
  static void on_key(GLFWwindow* window, int key, int scancode, int action, int modifiers);

  GLFWwindow* window_ = nullptr;
  std::vector<KeyPress> presses_;
};

}  // namespace cairn::viewer
