#include "runtime/paging/load_queue.h"

#include <algorithm>
#include <chrono>
#include <vector>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

using std::chrono::milliseconds;
using Clock = LoadQueue::Clock;

constexpr int kTileSize = 257;
constexpr std::uint64_t kNoLimit = UINT64_MAX;

IndexEntry tile(std::int32_t x) {
  IndexEntry entry;
  entry.layer = Layer::heights;
  entry.id = {2, x, 4};
  entry.bytes = 100;
  return entry;
}

/// Answers every request at once with this error.
TileSource failing(Error error) {
  return RequestTile(
      [error](const IndexEntry&, std::stop_token, TileDone done) { done(Result<LoadedTile>(error)); });
}

/// Answers no request before its queue is destroyed.
TileSource silent(std::vector<TileDone>& open) {
  return RequestTile(
      [&open](const IndexEntry&, std::stop_token, TileDone done) { open.push_back(std::move(done)); });
}

}  // namespace

TEST_CASE("a tile whose read fails is read again after pauses that double from 20 ms to 5 s") {
  TileTable table(kTileSize);
  LoadQueue queue(table, failing(failed("a.cairn: expected bytes, found none")), 1, kTileSize);
  const IndexEntry entry = tile(8);
  const std::vector<IndexEntry> wanted{entry};
  Clock::time_point now{};
  queue.set_wanted(wanted, now);
  for (int attempt = 1; attempt <= 12; ++attempt) {
    REQUIRE(table.is_due(key_of(entry), now));
    queue.submit(entry);
    CHECK_FALSE(table.is_due(key_of(entry), now));
    const auto failures = queue.receive(kNoLimit, now);
    // Four failures in a row may be a hiccup. The fifth is told once.
    CHECK(failures.size() == (attempt == kReportedTries ? 1 : 0));
    CHECK(table.only_failing(kReportedTries) == (attempt >= kReportedTries));
    const auto pause = milliseconds(std::min(20 << (attempt - 1), 5000));
    CHECK_FALSE(table.is_due(key_of(entry), now + pause - milliseconds(1)));
    now += pause;
    queue.set_wanted(wanted, now);
  }
}

TEST_CASE("a damaged tile is told at once and not read again") {
  TileTable table(kTileSize);
  LoadQueue queue(table, failing(bad_data("a.cairn: tile: expected one checksum, found another")), 1,
                  kTileSize);
  const std::vector<IndexEntry> wanted{tile(8)};
  const Clock::time_point now{};
  queue.set_wanted(wanted, now);
  queue.submit(tile(8));
  const auto failures = queue.receive(kNoLimit, now);
  REQUIRE(failures.size() == 1);
  CHECK(failures[0].error.code == ErrorCode::bad_data);
  CHECK(table.state(key_of(tile(8))) == TileState::damaged);
  CHECK(table.requested() == 0);
  queue.set_wanted(wanted, now);
  CHECK_FALSE(table.is_due(key_of(tile(8)), now + std::chrono::hours(1)));
}

TEST_CASE("a pause ends with what it was for: a tile that is wanted anew is read at once") {
  TileTable table(kTileSize);
  LoadQueue queue(table, failing(failed("a.cairn: expected bytes, found none")), 1, kTileSize);
  const std::vector<IndexEntry> wanted{tile(8)};
  const Clock::time_point now{};
  queue.set_wanted(wanted, now);
  queue.submit(tile(8));
  CHECK(queue.receive(kNoLimit, now).empty());
  CHECK_FALSE(table.is_due(key_of(tile(8)), now));
  queue.set_wanted({}, now);
  CHECK(table.requested() == 0);
  queue.set_wanted(wanted, now);
  CHECK(table.is_due(key_of(tile(8)), now));
}

TEST_CASE("a read that fails when its tile is needed no more is told to nobody") {
  std::vector<TileDone> open;
  TileTable table(kTileSize);
  LoadQueue queue(table, silent(open), 1, kTileSize);
  const std::vector<IndexEntry> wanted{tile(8)};
  const Clock::time_point now{};
  for (int attempt = 1; attempt < kReportedTries; ++attempt) {
    queue.set_wanted(wanted, now);
    queue.submit(tile(8));
    queue.set_wanted({}, now);
    CHECK(table.state(key_of(tile(8))) == TileState::stale);
    open.back()(Result<LoadedTile>(failed("a.cairn: expected bytes, found none")));
    CHECK(queue.receive(kNoLimit, now).empty());
    CHECK(table.state(key_of(tile(8))) == TileState::unknown);
    CHECK(table.bytes_under_way() == 0);
  }
}

TEST_CASE("a queue is full at eight tiles per worker, and counts the bytes that they will need") {
  std::vector<TileDone> open;
  TileTable table(kTileSize);
  LoadQueue queue(table, silent(open), 2, kTileSize);
  std::vector<IndexEntry> wanted;
  for (std::int32_t x = 0; x < 20; ++x) wanted.push_back(tile(x));
  const Clock::time_point now{};
  queue.set_wanted(wanted, now);
  CHECK(table.bytes_under_way() == 0);
  std::size_t submitted = 0;
  while (!queue.is_full()) queue.submit(wanted[submitted++]);
  CHECK(submitted == 16);
  CHECK(table.bytes_under_way() == 16 * decoded_bytes_bound(wanted[0], kTileSize));
  CHECK(table.bytes_under_way() >= 16 * sizeof(std::int32_t) * kTileSize * kTileSize);
}

}  // namespace cairn
