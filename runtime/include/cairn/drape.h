#pragma once

#include <vector>

#include <glm/vec3.hpp>

#include "cairn/geo.h"

namespace cairn {

/// A line on the ground, or a point where it has one place only.
struct DrapedLine {
  /// Straight in longitude and latitude from place to place, the short way round the Earth.
  std::vector<LonLat> places;
  glm::vec3 colour{1};  ///< linear RGB, 0 to 1
  float width_px = 3;   ///< of the line, or the diameter of the point
};

/// Lines and points that are drawn on the ground. Later ones lie over earlier ones.
struct Drape {
  std::vector<DrapedLine> lines;
};

}  // namespace cairn
