#include "runtime/lod/mesh/grid_positions.h"

#include <cmath>

#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"

namespace cairn {

GridPositions::GridPositions(const LatticePoint& corner, std::int64_t spacing, int side,
                             const Ellipsoid& ellipsoid) {
  const double ratio = 1 / ellipsoid.graphic_per_centric();
  for (int i = 0; i < side; ++i) {
    // A column on the antimeridian has one position, from whichever side it is worked out.
    const LonLat place = place_of(canonical({corner.x + i * spacing, corner.y + i * spacing}));
    const double lon = glm::radians(place.lon), lat = glm::radians(place.lat);
    columns_.push_back({std::cos(lon), std::sin(lon)});
    const double sine = std::sin(lat);
    const double normal = ellipsoid.semi_major_m / std::sqrt(1 - (1 - ratio) * sine * sine);
    rows_.push_back({std::cos(lat), sine, normal, normal * ratio});
  }
}

}  // namespace cairn
