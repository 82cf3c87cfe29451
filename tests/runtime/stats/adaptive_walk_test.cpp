#include "runtime/stats/adaptive_walk.h"

#include <algorithm>

#include <catch2/catch.hpp>

#include "runtime/stats/pack_walk.h"
#include "tests/support/flight_pack.h"

namespace cairn {

TEST_CASE("an adaptive walk keeps its tolerance, and under a budget says what it keeps instead") {
  const test::FlightPack pack;
  const auto reader = pack.open();
  const HasTile has = [&](const TileId& id) { return reader->find_index(Layer::heights, id).has_value(); };
  const TileId start = *middle_tile(*reader);
  const auto walk = kept_inside(random_walk(moves_of_kind("axis"), 40, 3), start, has);
  const auto largest = [](const AdaptiveWalk& adaptive) {
    std::size_t tiles = 0;
    for (const MoveCount& count : count_moves(adaptive.tiles)) tiles = std::max(tiles, count.total);
    return tiles;
  };
  const AdaptiveWalk fine = walk_adaptively({start, 4, 1, 0}, walk, reader);
  const AdaptiveWalk coarse = walk_adaptively({start, 4, 8, 0}, walk, reader);
  REQUIRE(fine.tiles.size() == walk.size() + 1);
  CHECK(fine.error_px <= 0.5);
  CHECK(coarse.error_px <= 4);
  CHECK(largest(coarse) < largest(fine));

  constexpr std::size_t kTiles = 20;
  const std::uint64_t budget = kTiles * decoded_bytes_bound(IndexEntry{}, reader->header().tile_size);
  const AdaptiveWalk limited = walk_adaptively({start, 4, 1, budget}, walk, reader);
  CHECK(largest(limited) <= kTiles);
  CHECK(limited.error_px > 0.5);
}

TEST_CASE("an eye that stays where it is loads nothing") {
  const test::FlightPack pack;
  const auto reader = pack.open();
  const std::vector<Move> none(5, Move{0, 0});
  for (const MoveCount& count : count_moves(walk_adaptively({*middle_tile(*reader)}, none, reader).tiles)) {
    CHECK(count.difference == 0);
  }
}

}  // namespace cairn
