#include "runtime/surface/area_sphere.h"

#include <algorithm>
#include <cmath>

#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"

namespace cairn {
namespace {

constexpr double kHighest_m = 20e3;

double nearest_to_equator(const GeoBounds& bounds) {
  return bounds.south > 0 ? bounds.south : bounds.north < 0 ? bounds.north : 0;
}

}  // namespace

SquareSphere sphere_around(const TileId& area, double low_m, double high_m, const Ellipsoid& ellipsoid) {
  const GeoBounds b = tile_bounds(area);
  const glm::dvec3 centre = to_geocentric({(b.west + b.east) / 2, std::min((b.south + b.north) / 2, 90.0)},
                                          (low_m + high_m) / 2, ellipsoid);
  // The way along the surface from the middle to a corner is no shorter than the chord.
  const double half =
      glm::radians(b.width()) / 2 * (largest_curvature_m(ellipsoid) + std::max(high_m, kHighest_m));
  const double half_east = half * std::cos(glm::radians(nearest_to_equator(b)));
  return {centre, std::hypot(half_east, half) + (high_m - low_m) / 2};
}

}  // namespace cairn
