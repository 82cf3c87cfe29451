#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <vector>

#include <glm/vec3.hpp>

namespace cairn {

/// The colour of a height; between two of a table colours change smoothly.
struct TintStop {
  double height_m = 0;  ///< in the pack's vertical datum
  glm::vec3 colour{0};  ///< linear RGB, 0 to 1
};

/// The most colours that a table may have.
inline constexpr std::size_t kMostTintStops = 16;

/// A table of colours with a name.
struct NamedTint {
  std::string_view name;
  std::string_view description;
  /// The heights of the table are not metres, but shares, 0 to 1, of the way from a pack's lowest ground to
  /// its highest.
  bool spreads = false;
  std::vector<TintStop> stops;  ///< heights ascend
};

/// Returns all tables. The first is what the Earth has where nothing else is asked for.
std::span<const NamedTint> tints();

/// Returns the table of this name; null where there is none.
const NamedTint* tint_named(std::string_view name);

/// Returns the colours of a table for a pack whose ground lies between two heights.
std::vector<TintStop> stops_of(const NamedTint& tint, double lowest_m, double highest_m);

}  // namespace cairn
