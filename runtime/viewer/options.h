#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

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
  double object_px = 2;
  bool no_objects = false;
  int samples = 4;  ///< a pixel
  std::optional<double> sea_m;
  double contours_m = 0;
  bool slopes = false;
  std::string tint;  ///< of tints(); empty: the body's own
  double imagery = 1;
  double exposure_ev = 0;
  std::string time;  ///< UTC; empty: the hour counts
  std::vector<std::filesystem::path> drapes;
  bool no_shadows = false;
  bool no_dither = false;
  bool no_fog = false;
  bool wireframe = false;
  bool levels = false;
  bool no_draw = false;

  bool is_headless() const {
    return !screenshot.empty() || !frames.empty() || !video.empty() || !stats.empty();
  }
};

}  // namespace cairn::viewer
