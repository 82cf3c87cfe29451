#pragma once

#include <glm/mat4x4.hpp>
#include <glm/vec3.hpp>

#include "cairn/geodesy.h"

namespace cairn {

/// The tangent plane of the ellipsoid at a place: coordinates are metres to the east, to the north and up.
/// The ellipsoid is by default that of WGS84; PackHeader::body has a pack's. Errors are a few nanometres.
/// Immutable, so that any number of threads may use one.
class EnuFrame {
 public:
  explicit EnuFrame(const Geodetic& origin, const Ellipsoid& ellipsoid = {});

  glm::dvec3 to_geocentric(const glm::dvec3& enu) const;
  glm::dvec3 from_geocentric(const glm::dvec3& geocentric) const;
  Geodetic to_geodetic(const glm::dvec3& enu) const;
  glm::dvec3 from_geodetic(const Geodetic& at) const;

  /// Returns the matrix that takes (east, north, up, 1) to geocentric metres; its inverse goes back.
  glm::dmat4 geocentric_from_enu() const;

 private:
  Ellipsoid ellipsoid_;
  glm::dvec3 origin_;
  LocalFrame axes_;
};

}  // namespace cairn
