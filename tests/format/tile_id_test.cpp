#include "cairn/tile_id.h"

#include <random>

#include <catch2/catch.hpp>

namespace cairn {

TEST_CASE("the Earth is one tile at level -9 and 360x180 cells at level 0") {
  CHECK(tiles_around(-9) == 1);
  CHECK(tiles_pole_to_pole(-9) == 1);
  CHECK(tiles_around(0) == 360);
  CHECK(tiles_pole_to_pole(0) == 180);
  CHECK(tiles_around(-4) == 23);  // 22.5, so the last one overhangs
  CHECK(tiles_pole_to_pole(-3) == 23);
}

TEST_CASE("a cell's tile is named by its south-west corner") {
  CHECK(tile_at({28.5, 36.5}, 0) == TileId{0, 208, 126});
  const GeoBounds bounds = tile_bounds({0, 208, 126});
  CHECK(bounds.west == 28.0);
  CHECK(bounds.south == 36.0);
}

TEST_CASE("the antimeridian wraps and the north pole belongs to the last row") {
  CHECK(tile_at({180.0, 0.0}, 2) == tile_at({-180.0, 0.0}, 2));
  CHECK(tile_at({-180.0000000000000001, 90.0}, 2) == TileId{2, 0, 719});
  CHECK(neighbour_of({2, 0, 5}, -1, 0) == TileId{2, 1439, 5});
  CHECK(neighbour_of({2, 1439, 5}, 1, 1) == TileId{2, 0, 6});
}

TEST_CASE("every place lies in its tile, and the tile in its ancestors, at every level") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> lon(-180, 180), lat(-90, 90);
  for (int i = 0; i < 2000; ++i) {
    const LonLat place{lon(random), lat(random)};
    for (int level = kMinLevel; level <= kMaxLevel; ++level) {
      const TileId id = tile_at(place, level);
      REQUIRE(is_valid(id));
      REQUIRE(tile_bounds(id).contains(place));
      if (level == kMinLevel) continue;
      const TileId parent = tile_at(place, level - 1);
      REQUIRE(parent_of(id) == parent);
      REQUIRE(child_of(parent, quadrant_of(id)) == id);
      REQUIRE(ancestor_of(id, kMinLevel) == TileId{kMinLevel, 0, 0});
    }
  }
}

}  // namespace cairn
