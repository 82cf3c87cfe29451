#include "cairn/enu_frame.h"

#include <glm/geometric.hpp>

namespace cairn {

EnuFrame::EnuFrame(const Geodetic& origin, const Ellipsoid& ellipsoid)
    : ellipsoid_(ellipsoid),
      origin_(cairn::to_geocentric(origin.place, origin.height_m, ellipsoid)),
      axes_(local_frame(origin.place)) {}

glm::dvec3 EnuFrame::to_geocentric(const glm::dvec3& enu) const {
  return origin_ + axes_.east * enu.x + axes_.north * enu.y + axes_.up * enu.z;
}

glm::dvec3 EnuFrame::from_geocentric(const glm::dvec3& geocentric) const {
  const glm::dvec3 to = geocentric - origin_;
  return {glm::dot(to, axes_.east), glm::dot(to, axes_.north), glm::dot(to, axes_.up)};
}

Geodetic EnuFrame::to_geodetic(const glm::dvec3& enu) const {
  return cairn::to_geodetic(to_geocentric(enu), ellipsoid_);
}

glm::dvec3 EnuFrame::from_geodetic(const Geodetic& at) const {
  return from_geocentric(cairn::to_geocentric(at.place, at.height_m, ellipsoid_));
}

glm::dmat4 EnuFrame::geocentric_from_enu() const {
  return {glm::dvec4(axes_.east, 0), glm::dvec4(axes_.north, 0), glm::dvec4(axes_.up, 0),
          glm::dvec4(origin_, 1)};
}

}  // namespace cairn
