#include "runtime/paging/tile_cache.h"

#include <catch2/catch.hpp>

#include "tests/support/flight_pack.h"

namespace cairn {
namespace {

TileKey key(int x) {
  return {Layer::heights, {3, x, 0}};
}

LoadedTile tile_of(std::size_t samples) {
  return {std::make_shared<const HeightTile>(HeightTile{0, std::vector<std::int32_t>(samples), {}}), nullptr};
}

}  // namespace

TEST_CASE("the least recently pinned tiles go first, the pinned ones never") {
  TileCache cache;
  for (int x = 0; x < 6; ++x) cache.insert(key(x), tile_of(1000));
  const std::uint64_t each = cache.bytes() / 6;
  cache.unpin_all();
  cache.pin(key(0));
  cache.unpin_all();
  cache.pin(key(1));
  cache.pin(key(2));
  CHECK(cache.pinned_bytes() == 2 * each);
  CHECK(cache.shrink_to(4 * each));
  CHECK(cache.take_evicted() == std::vector<TileKey>{key(3), key(4)});
  CHECK(cache.shrink_to(3 * each));
  CHECK(cache.take_evicted() == std::vector<TileKey>{key(5)});
  CHECK_FALSE(cache.shrink_to(each));
  CHECK(cache.take_evicted() == std::vector<TileKey>{key(0)});
  CHECK(cache.find(key(1)) != nullptr);
  CHECK(cache.find(key(0)) == nullptr);
  CHECK(cache.bytes() == 2 * each);
  CHECK_FALSE(cache.pin(key(0)));
}

TEST_CASE("a tile inserted after the pinned ones can still be evicted") {
  TileCache cache;
  cache.insert(key(0), tile_of(10));
  cache.unpin_all();
  cache.pin(key(0));
  cache.insert(key(1), tile_of(10));
  CHECK_FALSE(cache.shrink_to(0));
  CHECK(cache.take_evicted() == std::vector<TileKey>{key(1)});
}

TEST_CASE("a tile's bytes are what it takes from the heap") {
  for (const std::size_t samples : {1000u, 66049u, 263169u}) {
    const std::uint64_t before = test::heap_bytes();
    const LoadedTile tile = tile_of(samples);
    const std::uint64_t taken = test::heap_bytes() - before;
    CHECK(tile.bytes() >= taken);
    CHECK(tile.bytes() <= taken + 5000);
  }
}

}  // namespace cairn
