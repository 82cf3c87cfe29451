#pragma once

#include <optional>

#include <glm/vec2.hpp>

#include "runtime/viewer/camera_controls.h"

namespace cairn::viewer {

/// Keys as GLFW names them, of the frame that ImGui has begun; none while the user types into the panel.
bool key_held(int key);
bool shift_held();

/// Where the picture was clicked in this frame, 0 to 1 from its upper left corner: the button went down and
/// up again with no drag between.
std::optional<glm::dvec2> clicked();

/// Where the cursor is on the picture, 0 to 1 from its upper left corner; nullopt where it is on a panel or
/// outside.
std::optional<glm::dvec2> cursor_on_picture();

/// What keys, mouse and game pad say about the camera. Call between ImGui's NewFrame and Render.
ControlInput read_controls(double dt_s);

}  // namespace cairn::viewer
