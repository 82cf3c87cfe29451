#include "runtime/paging/tile_table.h"

#include <catch2/catch.hpp>

#include "tests/support/flight_pack.h"

namespace cairn {
namespace {

using namespace std::chrono_literals;

constexpr int kTileSize = 257;

IndexEntry entry(int x) {
  IndexEntry entry;
  entry.id = {3, x, 0};
  entry.bytes = 100;
  return entry;
}

TileKey key(int x) {
  return key_of(entry(x));
}

LoadedTile tile_of(std::size_t samples) {
  return {std::make_shared<const HeightTile>(HeightTile{0, std::vector<std::int32_t>(samples), {}}), nullptr};
}

}  // namespace

TEST_CASE("the least recently pinned tiles go first, the pinned ones never") {
  TileTable table(kTileSize);
  for (int x = 0; x < 6; ++x) table.insert(key(x), tile_of(1000));
  const std::uint64_t each = table.bytes() / 6;
  table.unpin_all();
  table.pin(key(0));
  table.unpin_all();
  table.pin(key(1));
  table.pin(key(2));
  CHECK(table.pinned_bytes() == 2 * each);
  CHECK(table.shrink_to(4 * each));
  CHECK(table.take_evicted() == std::vector<TileKey>{key(3), key(4)});
  CHECK(table.shrink_to(3 * each));
  CHECK(table.take_evicted() == std::vector<TileKey>{key(5)});
  CHECK_FALSE(table.shrink_to(each));
  CHECK(table.take_evicted() == std::vector<TileKey>{key(0)});
  CHECK(table.find(key(1)) != nullptr);
  CHECK(table.find(key(0)) == nullptr);
  CHECK(table.bytes() == 2 * each);
  CHECK_FALSE(table.pin(key(0)));
}

TEST_CASE("a tile inserted after the pinned ones can still be evicted") {
  TileTable table(kTileSize);
  table.insert(key(0), tile_of(10));
  table.unpin_all();
  table.pin(key(0));
  table.insert(key(1), tile_of(10));
  CHECK_FALSE(table.shrink_to(0));
  CHECK(table.take_evicted() == std::vector<TileKey>{key(1)});
}

TEST_CASE("a tile goes from wanted to memory, and its bytes are counted on the way") {
  TileTable table(kTileSize);
  const TileTable::Clock::time_point now;
  const std::vector<IndexEntry> both{entry(0), entry(1)};
  CHECK(table.state(key(0)) == TileState::unknown);
  table.set_wanted(both, now);
  CHECK(table.state(key(0)) == TileState::wanted);
  CHECK(table.is_due(key(0), now));
  table.submit(key(0));
  table.submit(key(1));
  CHECK(table.state(key(0)) == TileState::under_way);
  CHECK_FALSE(table.is_due(key(0), now));
  CHECK(table.bytes_under_way() == 2 * decoded_bytes_bound(entry(0), kTileSize));
  table.arrive(key(0), tile_of(100));
  CHECK(table.state(key(0)) == TileState::resident);
  CHECK(table.bytes_unseen() == 100);
  table.note_seen(key(0));
  table.note_seen(key(0));
  CHECK(table.bytes_unseen() == 0);
  // What is no longer wanted is stale while it is read, and wanted again if it is.
  table.set_wanted({}, now);
  CHECK(table.state(key(1)) == TileState::stale);
  table.set_wanted(both, now);
  CHECK(table.state(key(1)) == TileState::under_way);
  table.stop(key(1));
  CHECK(table.state(key(1)) == TileState::wanted);
  table.set_wanted({}, now);
  CHECK(table.state(key(1)) == TileState::unknown);
  CHECK(table.requested() == 0);
  CHECK(table.under_way() == 0);
  CHECK(table.bytes_under_way() == 0);
}

TEST_CASE("a read that fails pauses, a tile that goes on failing is absent for a while, longer each time") {
  TileTable table(kTileSize);
  TileTable::Clock::time_point now;
  const std::vector<IndexEntry> one{entry(0)};
  auto absence = 320ms;
  for (int round = 0; round < 7; ++round) {
    table.set_wanted(one, now);
    for (int tries = 1; tries <= 5; ++tries) {
      CHECK_FALSE(table.only_failing(5));
      table.submit(key(0));
      CHECK(table.fail(key(0), 20ms, now) == tries);
      CHECK(table.state(key(0)) == TileState::pausing);
      CHECK_FALSE(table.is_due(key(0), now + 19ms));
      now += 20ms;
      CHECK(table.is_due(key(0), now));
    }
    CHECK(table.only_failing(5));
    CHECK(table.report(key(0)) == (round == 0));
    table.set_failing(key(0), 320ms, now);
    CHECK(table.failing() == std::vector<TileKey>{key(0)});
    CHECK(table.only_failing(5));
    CHECK_FALSE(table.restore(now + absence - 1ms));
    now += absence;
    CHECK(table.restore(now));
    CHECK(table.state(key(0)) == TileState::unknown);
    absence = std::min<std::chrono::milliseconds>(2 * absence, 16 * 320ms);
  }
  table.set_wanted(one, now);
  table.submit(key(0));
  table.arrive(key(0), tile_of(1));
  CHECK(table.report(key(0)));  // it could be read meanwhile
}

TEST_CASE("a damaged tile stays absent, and a stale one that fails is forgotten") {
  TileTable table(kTileSize);
  const TileTable::Clock::time_point now;
  const std::vector<IndexEntry> both{entry(0), entry(1)};
  table.set_wanted(both, now);
  table.submit(key(0));
  table.submit(key(1));
  table.set_damaged(key(0));
  table.set_wanted({}, now);
  table.fail(key(1), 20ms, now);
  CHECK(table.state(key(0)) == TileState::damaged);
  CHECK(table.state(key(1)) == TileState::unknown);
  CHECK_FALSE(table.restore(now + 1000h));
  CHECK(table.failing().empty());
  table.set_wanted(both, now);
  CHECK(table.state(key(0)) == TileState::damaged);
  CHECK(table.requested() == 1);
  CHECK(table.under_way() == 0);
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
