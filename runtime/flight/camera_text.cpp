#include "runtime/flight/camera_text.h"

#include <array>
#include <charconv>
#include <cmath>
#include <span>
#include <utility>

namespace cairn::viewer {
namespace {

constexpr int kMaxSide = 16384;

/// Fills `values` from numbers parted by `separator`; whether that was all.
template <class T>
bool parse_numbers(std::string_view text, char separator, std::span<T> values) {
  const char* at = text.data();
  const char* end = at + text.size();
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0 && (at == end || *at++ != separator)) return false;
    const auto [next, error] = std::from_chars(at, end, values[i]);
    if (error != std::errc()) return false;
    at = next;
  }
  return at == end;
}

Error unexpected(const char* what, const char* expected, std::string_view found) {
  return usage_error(std::string(what) + ": expected " + expected + ", found " + std::string(found));
}

}  // namespace

Result<ViewState> parse_camera(std::string_view text) {
  std::array<double, 5> v{};
  const char* expected = "LON,LAT,ALT,HEADING,PITCH, degrees and metres";
  if (!parse_numbers(text, ',', std::span<double>(v))) return unexpected("camera", expected, text);
  for (const double value : v) {
    if (!std::isfinite(value)) return unexpected("camera", expected, text);
  }
  if (std::abs(v[1]) > 90) return unexpected("camera", "a latitude within 90", text);
  if (std::abs(v[4]) > 90) return unexpected("camera", "a pitch within 90", text);
  if (v[2] < -12000 || v[2] > 1e9)
    return unexpected("camera", "an altitude from -12 km to 1,000,000 km", text);
  ViewState view;
  view.eye = {v[0], v[1]};
  view.height_m = v[2];
  view.heading_deg = v[3];
  view.pitch_deg = v[4];
  return view;
}

Result<Size> parse_size(std::string_view text) {
  std::array<int, 2> v{};
  if (!parse_numbers(text, 'x', std::span<int>(v)) || v[0] < 1 || v[1] < 1 || v[0] > kMaxSide ||
      v[1] > kMaxSide) {
    return unexpected("size", "WIDTHxHEIGHT in pixels, each from 1 to 16384", text);
  }
  return Size{v[0], v[1]};
}

Result<glm::vec3> parse_colour(std::string_view text) {
  constexpr std::array<std::pair<std::string_view, glm::vec3>, 8> kNames = {{{"black", {0, 0, 0}},
                                                                             {"red", {1, 0, 0}},
                                                                             {"green", {0, 1, 0}},
                                                                             {"blue", {0, 0, 1}},
                                                                             {"yellow", {1, 1, 0}},
                                                                             {"magenta", {1, 0, 1}},
                                                                             {"cyan", {0, 1, 1}},
                                                                             {"white", {1, 1, 1}}}};
  for (const auto& [name, colour] : kNames) {
    if (name == text) return colour;
  }
  return unexpected("colour", "black, red, green, blue, yellow, magenta, cyan or white", text);
}

}  // namespace cairn::viewer
