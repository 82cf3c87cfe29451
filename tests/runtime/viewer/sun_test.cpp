#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/flight/camera_text.h"
#include "runtime/light/sun_position.h"
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

TEST_CASE("the sun of a date stands where an ephemeris has it, to a fiftieth of a degree") {
  struct Known {
    double utc_s, lon, lat;
  };
  // PyEphem 4.1.4 (VSOP87): where the sun is in the zenith.
  constexpr Known kKnown[] = {
      {-631152000, -179.1900, -23.0707},  // 1950-01-01 00:00
      {-14182980, -122.6802, 20.5850},    // 1969-07-20 20:17
      {545080860, -109.9053, 7.9682},     // 1987-04-10 19:21
      {946728000, 0.8214, -23.0324},      // 2000-01-01 12:00
      {1352086400, 122.5651, -15.7764},   // 2012-11-05 03:33:20
      {1782055800, -52.0378, 23.4376},    // 2026-06-21 15:30
      {1796104800, 87.2287, -21.8048},    // 2026-12-01 06:00
      {2499856440, -6.6776, 0.1332},      // 2049-03-20 12:34
  };
  double worst_deg = 0;
  for (const Known& known : kKnown) {
    const glm::dvec3 sun = sun_position(known.utc_s);
    CHECK(glm::length(sun) == Approx(1));
    const double lon = glm::radians(known.lon), lat = glm::radians(known.lat);
    const glm::dvec3 truth(std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat));
    worst_deg = std::max(worst_deg, glm::degrees(glm::length(sun - truth)));
  }
  WARN("the sun is off by " << worst_deg << " degrees at most");
  CHECK(worst_deg < 0.02);
}

TEST_CASE("a time is read and written alike, and what is none is refused") {
  CHECK(*parse_time("2000-01-01T12:00Z") == 946728000);
  CHECK(*parse_time("1969-07-20T20:17:00Z") == -14182980);
  for (const char* text : {"2026-06-21T15:30:20Z", "1950-01-01T00:00:00Z", "2050-12-31T23:59:59Z"}) {
    CHECK(time_text(*parse_time(text)) == text);
  }
  for (const char* text : {"", "2026-06-21", "2026-06-21T15:30", "2026-02-30T15:30Z", "2026-06-21T24:00Z",
                           "2026-06-21T15:60Z", "1949-06-21T15:30Z", "2051-06-21T15:30Z", "2026-06-21 15:30Z",
                           "+026-06-21T15:30Z", "2026-06-21T15:30:61Z", "2026-06-21T15:30Zx"}) {
    CAPTURE(text);
    const auto time = parse_time(text);
    REQUIRE(!time.ok());
    CHECK(time.error().code == ErrorCode::usage);
  }
}

}  // namespace cairn::viewer
