#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include <glm/vec3.hpp>

#include "format/status.h"
#include "runtime/view/view_state.h"

namespace cairn::viewer {

/// What the command line of cairn-view asks for.
struct Options {
  std::filesystem::path pack;
  std::string camera;  ///< "LON,LAT,ALT,HEADING,PITCH"; empty: the pack's bounds fill the view
  double fov_deg = 45;
  std::string size = "1280x720";
  std::filesystem::path screenshot;
  std::filesystem::path flight;
  std::filesystem::path frames;
  std::filesystem::path video;
  std::filesystem::path stats;
  std::string hole_colour;
  double hour = 10;
  double tolerance_px = 1;
  std::string method;  ///< of lod_methods(); empty: the renderer's own mesh
  std::uint64_t cache_mib = 512;
  bool no_fog = false;
  bool wireframe = false;
  bool levels = false;
  bool no_draw = false;

  bool is_headless() const {
    return !screenshot.empty() || !frames.empty() || !video.empty() || !stats.empty();
  }
};

/// usage names the option, what it expects and what it found.
Result<ViewState> parse_camera(std::string_view text);
struct Size {
  int width = 0;
  int height = 0;
};
Result<Size> parse_size(std::string_view text);
/// One of the eight corners of the colour cube, by its name: "magenta".
Result<glm::vec3> parse_colour(std::string_view text);

}  // namespace cairn::viewer
