#include "runtime/flight/camera_text.h"

#include <array>
#include <charconv>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdio>
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

std::string time_text(double utc_s) {
  const auto seconds = static_cast<std::int64_t>(std::floor(utc_s));
  const std::int64_t days = seconds >= 0 ? seconds / 86400 : (seconds - 86399) / 86400;
  const int of_day = static_cast<int>(seconds - days * 86400);
  const std::chrono::year_month_day date{std::chrono::sys_days(std::chrono::days(days))};
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%04d-%02u-%02uT%02d:%02d:%02dZ", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), of_day / 3600,
                of_day / 60 % 60, of_day % 60);
  return text.data();
}

Result<double> parse_time(std::string_view text) {
  const auto is_written = [text] {
    constexpr std::string_view kForm = "dddd-dd-ddTdd:dd:ddZ";
    if (text.size() != 17 && text.size() != 20) return false;
    for (std::size_t i = 0; i < text.size(); ++i) {
      const char form = i + 1 == text.size() ? 'Z' : kForm[i];
      if (form == 'd' ? text[i] < '0' || text[i] > '9' : text[i] != form) return false;
    }
    return true;
  };
  constexpr const char* kExpected = "UTC as 2026-06-21T15:30Z, years 1950 to 2050";
  if (!is_written()) return unexpected("time", kExpected, text);
  const auto number = [text](std::size_t at, std::size_t digits) {
    int value = 0;
    for (const char c : text.substr(at, digits)) value = 10 * value + (c - '0');
    return value;
  };
  const std::chrono::year_month_day date{std::chrono::year(number(0, 4)),
                                         std::chrono::month(static_cast<unsigned>(number(5, 2))),
                                         std::chrono::day(static_cast<unsigned>(number(8, 2)))};
  const int hour = number(11, 2), minute = number(14, 2), second = text.size() == 20 ? number(17, 2) : 0;
  if (!date.ok() || number(0, 4) < 1950 || number(0, 4) > 2050 || hour > 23 || minute > 59 || second > 59) {
    return unexpected("time", kExpected, text);
  }
  const auto days = std::chrono::sys_days(date).time_since_epoch().count();
  return 86400.0 * static_cast<double>(days) + 3600.0 * hour + 60.0 * minute + second;
}

}  // namespace cairn::viewer
