#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/viewer/scene.h"

namespace cairn::viewer {

TEST_CASE("the sun moves no faster than the place, across the equator and the tropics") {
  for (const double hour : {6.0, 8.0, 12.0, 17.5}) {
    for (double lat = -89.5; lat < 89.5; lat += 0.01) {
      const glm::dvec3 a = sun_direction({30, lat}, hour), b = sun_direction({30, lat + 0.01}, hour);
      CHECK(glm::degrees(std::acos(std::min(1.0, glm::dot(a, b)))) < 0.0101);
    }
  }
}

TEST_CASE("at noon the sun is as high as it gets on any day of the year") {
  for (double lat = -90; lat <= 90; lat += 2.5) {
    const glm::dvec3 sun = sun_direction({-70, lat}, 12);
    CHECK(glm::length(sun) == Approx(1));
    const double height_deg =
        glm::degrees(std::asin(std::min(1.0, glm::dot(sun, local_frame({-70, lat}).up))));
    const double highest_deg = 90 - std::max(0.0, std::abs(lat) - 23.44);
    CHECK(height_deg == Approx(highest_deg).margin(1e-4));
  }
}

}  // namespace cairn::viewer
