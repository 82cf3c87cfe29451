#pragma once

#include <string>
#include <string_view>

#include "cairn/geo.h"
#include "cairn/status.h"

namespace cairn {

/// An object as its file says it.
struct ObjectPlace {
  LonLat at;
  std::string model;
  double heading_degrees = 0;  ///< clockwise from north
  double scale = 1;
  double height_m = 0;       ///< of the foot: above the ground, or in the pack's vertical datum
  bool is_absolute = false;  ///< the latter
};

inline constexpr double kLeastScale = 1.0 / 4096;
inline constexpr double kMostScale = 65535.0 / 4096;

/// Returns what is wrong with a number, if anything: NaN is outside every range.
Status check_range(const char* what, double value, double low, double high);

/// Returns what is wrong with a place's numbers, if anything.
Status check_place(const ObjectPlace& place);

/// Sets a place's mode from its word.
Status set_mode(std::string_view word, ObjectPlace& place);

}  // namespace cairn
