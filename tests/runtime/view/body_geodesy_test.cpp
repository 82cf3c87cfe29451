// On the ellipsoids of other bodies: GeographicLib is the oracle.
#include <cmath>
#include <random>

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/LocalCartesian.hpp>
#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "cairn/body.h"
#include "cairn/bounding_volume.h"
#include "cairn/enu_frame.h"
#include "cairn/geodesy.h"
#include "cairn/view_state.h"
#include "runtime/lod/mesh/grid_positions.h"
#include "runtime/surface/area_sphere.h"
#include "runtime/surface/axis_table.h"
#include "runtime/view/horizon.h"

namespace cairn {
namespace {

const Ellipsoid kBodies[] = {known_body("Moon")->shape, known_body("Mars")->shape, known_body("Venus")->shape,
                             known_body("Ceres")->shape};

GeographicLib::Geocentric oracle_of(const Ellipsoid& e) {
  return {e.semi_major_m, e.flattening()};
}

}  // namespace

TEST_CASE("places on other bodies are where GeographicLib has them, and come back") {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> lon(-180, 180), lat(-90, 90), height(-8000, 50000);
  for (const Ellipsoid& e : kBodies) {
    const GeographicLib::Geocentric oracle = oracle_of(e);
    for (int i = 0; i < 300; ++i) {
      const LonLat place{lon(random), lat(random)};
      const double h = height(random);
      glm::dvec3 expected;
      oracle.Forward(place.lat, place.lon, h, expected.x, expected.y, expected.z);
      const glm::dvec3 found = to_geocentric(place, h, e);
      REQUIRE(glm::length(found - expected) < 1e-7);
      const Geodetic back = to_geodetic(found, e);
      REQUIRE(std::abs(back.height_m - h) < 1e-6);
      REQUIRE(glm::length(to_geocentric(back.place, back.height_m, e) - found) < 1e-6);
      ViewState view;
      view.eye = place;
      view.height_m = h;
      view.ellipsoid = e;
      REQUIRE(glm::length(camera_frame(view).position - expected) < 1e-7);
    }
  }
}

TEST_CASE("tangent planes of other bodies are GeographicLib's") {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> lon(-180, 180), lat(-89, 89), height(-5000, 50000), near(-1, 1);
  for (const Ellipsoid& e : kBodies) {
    for (int i = 0; i < 100; ++i) {
      const Geodetic origin{{lon(random), lat(random)}, height(random)};
      const Geodetic at{{origin.place.lon + near(random), origin.place.lat + near(random)}, height(random)};
      const GeographicLib::LocalCartesian oracle(origin.place.lat, origin.place.lon, origin.height_m,
                                                 oracle_of(e));
      glm::dvec3 expected;
      oracle.Forward(at.place.lat, at.place.lon, at.height_m, expected.x, expected.y, expected.z);
      const EnuFrame frame(origin, e);
      REQUIRE(glm::length(frame.from_geodetic(at) - expected) < 1e-7);
      REQUIRE(std::abs(frame.to_geodetic(expected).height_m - at.height_m) < 1e-6);
    }
  }
}

TEST_CASE("the tables of vertices have the positions of the body") {
  for (const Ellipsoid& e : kBodies) {
    for (const TileId& id : {TileId{-9, 0, 0}, TileId{0, 200, 95}, TileId{3, 1733, 1080}}) {
      const auto columns = column_table(id.level, id.x, 257);
      const auto rows = row_table(id.level, id.y, 257, e);
      const GridPositions grid(south_west_of(id), lattice_width(id.level) / 256, 257, e);
      const GeoBounds b = tile_bounds(id);
      for (int i = 0; i < 257; i += 16) {
        const LonLat place{b.west + b.width() * i / 256, b.south + b.height() * i / 256};
        if (place.lon > 180 || place.lat > 90) continue;
        const auto at = static_cast<std::size_t>(i);
        const glm::dvec3 expected = to_geocentric(place, 1234, e);
        CHECK(glm::length(position_of(columns[at], rows[at], 1234) - expected) < 1e-7);
        CHECK(glm::length(grid.at(i, i, 1234) - expected) < 1e-7);
      }
    }
  }
}

TEST_CASE("volumes and spheres around tiles of other bodies enclose their ground") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> part(0, 1);
  for (const Ellipsoid& e : kBodies) {
    const Occluder occluder(-9000, e);
    for (const TileId& id : {TileId{-6, 2, 1}, TileId{-3, 10, 20}, TileId{0, 100, 3}, TileId{2, 700, 400}}) {
      const GeoBounds b = tile_bounds(id);
      const BoundingVolume volume = bounding_volume(b, -8000, 21000, occluder);
      const SquareSphere sphere = sphere_around(id, -8000, 21000, e);
      for (int i = 0; i < 300; ++i) {
        const LonLat place{std::min(b.west + part(random) * b.width(), 180.0),
                           std::min(b.south + part(random) * b.height(), 90.0)};
        const glm::dvec3 point = to_geocentric(place, -8000 + 29000 * part(random), e);
        REQUIRE(volume.distance_m(point) == 0);
        REQUIRE(glm::length(point - sphere.centre) <= sphere.radius_m);
      }
    }
  }
}

}  // namespace cairn
