#include "cairn/enu_frame.h"

#include <random>

#include <GeographicLib/LocalCartesian.hpp>
#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

namespace cairn {

TEST_CASE("east, north and up are those of GeographicLib's LocalCartesian") {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> lon(-180, 180), lat(-90, 90), height(-500, 50000), near(-5, 5);
  for (int i = 0; i < 500; ++i) {
    const Geodetic origin{{lon(random), i % 50 == 0 ? (i % 100 == 0 ? 90.0 : -90.0) : lat(random)},
                          height(random)};
    const EnuFrame frame(origin);
    const GeographicLib::LocalCartesian oracle(origin.place.lat, origin.place.lon, origin.height_m);
    const Geodetic at{
        {origin.place.lon + near(random), std::clamp(origin.place.lat + near(random), -90.0, 90.0)},
        height(random)};
    glm::dvec3 expected;
    oracle.Forward(at.place.lat, at.place.lon, at.height_m, expected.x, expected.y, expected.z);
    const glm::dvec3 enu = frame.from_geodetic(at);
    REQUIRE(glm::length(enu - expected) < 1e-7);
    const glm::dvec3 point = to_geocentric(at.place, at.height_m);
    REQUIRE(glm::length(frame.to_geocentric(enu) - point) < 1e-7);
    REQUIRE(glm::length(glm::dvec3(frame.geocentric_from_enu() * glm::dvec4(enu, 1)) - point) < 1e-7);
    const Geodetic back = frame.to_geodetic(enu);
    REQUIRE(glm::length(to_geocentric(back.place, back.height_m) - point) < 1e-7);
    REQUIRE(glm::length(frame.from_geocentric(point) - enu) < 1e-7);
  }
}

}  // namespace cairn
