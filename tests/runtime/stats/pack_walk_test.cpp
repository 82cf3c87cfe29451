#include "runtime/stats/pack_walk.h"

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>

#include "runtime/stats/roughness.h"
#include "tests/support/flight_pack.h"

namespace cairn {

TEST_CASE("a walk over a pack stays over it and loads what its moves add") {
  const test::FlightPack pack;
  const auto reader = pack.open();
  const HasTile has = [&](const TileId& id) { return reader->find_index(Layer::heights, id).has_value(); };
  const auto start = middle_tile(*reader);
  REQUIRE(start.has_value());
  CHECK(start->level == test::FlightPack::kFinest);
  const auto walk = kept_inside(random_walk(moves_of_kind("random"), 500, 2), *start, has);
  TileId eye = *start;
  for (const Move& move : walk) {
    eye = moved(eye, move);
    REQUIRE(has(eye));
  }
  const CountSpec spec{*start, 4, RefinementPattern::restricted, 8, has};
  TimedLoader loader(read_from(reader), 2, reader->header().tile_size);
  const auto loads = load_walk(shown_along(spec, walk), *reader, loader);
  REQUIRE(loads.ok());
  const auto counts = count_moves(shown_along(spec, walk));
  REQUIRE(loads->size() == counts.size());
  for (std::size_t i = 0; i < counts.size(); ++i)
    CHECK(((*loads)[i].bytes > 0) == (counts[i].difference > 0));
}

TEST_CASE("a tile that cannot be read ends a timed walk with its error") {
  const test::FlightPack pack;
  const auto reader = pack.open();
  TimedLoader loader([](const IndexEntry&) -> Result<LoadedTile> { return failed("disk: gone"); }, 2,
                     reader->header().tile_size);
  const std::vector<IndexEntry> tiles(3, reader->entry(0));
  const auto load = loader.load(tiles);
  REQUIRE_FALSE(load.ok());
  CHECK(load.error().message == "disk: gone");
}

TEST_CASE("a plane has no roughness, and a spike has the spike's over its node's width") {
  HeightTile tile{9, std::vector<std::int32_t>(81), {}};
  for (int row = 0; row < 9; ++row) {
    for (int column = 0; column < 9; ++column)
      tile.samples[static_cast<std::size_t>(9 * row + column)] = 3 * column - 7 * row;
  }
  const auto flat = roughness_of(tile);
  REQUIRE(flat.size() == 16 + 4 + 1);
  CHECK(*std::max_element(flat.begin(), flat.end()) == 0);
  tile.samples[static_cast<std::size_t>(9 * 1 + 1)] += 100;  // the middle of the south-western finest node
  const auto spiked = roughness_of(tile);
  CHECK(spiked[0] == 50);
  CHECK(spiked[1] == 0);
  CHECK(spiked[16] == 25);  // its parent: half
  CHECK(spiked[20] == Approx(12.5));
}

}  // namespace cairn
