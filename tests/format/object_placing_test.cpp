// An object in its tile is where it was put, whatever turn of longitudes that was written in.
#include "cairn/object_placing.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

namespace cairn::test {

TEST_CASE(
    "an object lies within half a step of its place, in a tile of its size that is no finer than it may be") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> lon(-360, 360), lat(-90, 90), heading(-3600, 3600), power(-3, 18);
  for (int i = 0; i < 20000; ++i) {
    const ObjectPlacing placing{{lon(random), lat(random)}, heading(random), 1, std::exp2(power(random))};
    const int coarsest = static_cast<int>(random() % 12) - 9;
    const TileObject placed = tile_object(placing, {}, coarsest);
    CHECK(is_valid(placed.tile));
    CHECK(placed.tile.level == std::max(object_level(placing.size_m, {}), coarsest));
    const LonLat at = place_of(placed.tile, placed.object);
    const double step = std::ldexp(1.0, -placed.tile.level) / 65536;
    CHECK(std::abs(std::remainder(at.lon - placing.at.lon, 360.0)) <= step * 0.5001 + 1e-12);
    CHECK(std::abs(at.lat - placing.at.lat) <= step * 0.5001 + 1e-12);
    CHECK(std::abs(std::remainder(placed.object.heading_degrees() - placing.heading_degrees, 360.0)) <=
          180.0 / 65536 + 1e-9);
  }
}

TEST_CASE("poles, 180 degrees and scales beyond the range are placed at their edges") {
  for (const double lat : {-90.0, 90.0}) {
    for (const double lon : {-360.0, -180.0, 0.0, 180.0, 360.0}) {
      const TileObject placed = tile_object({{lon, lat}, 0, 1, 10}, {});
      CHECK(is_valid(placed.tile));
      CHECK(std::abs(place_of(placed.tile, placed.object).lat - lat) <= 1e-6);
    }
  }
  CHECK(tile_object({{-180, 0}, 0, 1, 10}, {}).tile == tile_object({{180, 0}, 0, 1, 10}, {}).tile);
  CHECK(tile_object({{0, 0}, 0, 1e-9, 10}, {}).object.scale == 1);
  CHECK(tile_object({{0, 0}, 0, 1e9, 10}, {}).object.scale == 65535);
  CHECK(tile_object({{0, 0}, 0, 1.5, 10}, {}).object.scale == 6144);
  CHECK(tile_object({{0, 0}, -90, 1, 10}, {}).object.heading == 49152);
}

}  // namespace cairn::test
