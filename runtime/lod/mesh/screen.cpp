#include "runtime/lod/mesh/screen.h"

#include "cairn/geodesy.h"

namespace cairn {

glm::dvec3 to_geocentric(const LatticePoint& point, double height_m, const Ellipsoid& ellipsoid) {
  return to_geocentric(place_of(point), height_m, ellipsoid);
}

}  // namespace cairn
