#include "runtime/surface/area_sphere.h"

#include <algorithm>
#include <cmath>

#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"

namespace cairn {
namespace {

constexpr double kLargestRadius = 6420000;  // of curvature, terrain included

double nearest_to_equator(const GeoBounds& bounds) {
  return bounds.south > 0 ? bounds.south : bounds.north < 0 ? bounds.north : 0;
}

}  // namespace

SquareSphere sphere_around(const TileId& area, double low_m, double high_m) {
  const GeoBounds b = tile_bounds(area);
  const glm::dvec3 centre =
      to_geocentric({(b.west + b.east) / 2, std::min((b.south + b.north) / 2, 90.0)}, (low_m + high_m) / 2);
  // The way along the surface from the middle to a corner is no shorter than the chord.
  const double half = glm::radians(b.width()) / 2 * kLargestRadius;
  const double half_east = half * std::cos(glm::radians(nearest_to_equator(b)));
  return {centre, std::hypot(half_east, half) + (high_m - low_m) / 2};
}

}  // namespace cairn
