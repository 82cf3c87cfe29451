#pragma once

#include <string>
#include <string_view>

#include <glm/vec3.hpp>

#include "cairn/status.h"
#include "cairn/view_state.h"

namespace cairn::viewer {

/// An error of these has the code usage, and names what was expected and what was found.
Result<ViewState> parse_camera(std::string_view text);
struct Size {
  int width = 0;
  int height = 0;
};
Result<Size> parse_size(std::string_view text);
/// One of the eight corners of the colour cube, by its name: "magenta".
Result<glm::vec3> parse_colour(std::string_view text);

/// Returns "2026-06-21T15:30:20Z".
std::string time_text(double utc_s);
/// Returns seconds since 1970 of "2026-06-21T15:30Z" or "2026-06-21T15:30:20Z", years 1950 to 2050.
Result<double> parse_time(std::string_view text);

}  // namespace cairn::viewer
