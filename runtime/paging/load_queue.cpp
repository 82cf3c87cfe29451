#include "runtime/paging/load_queue.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace cairn {
namespace {

constexpr std::chrono::milliseconds kFirstPause{20};
constexpr std::chrono::milliseconds kLongestPause{5000};
// Enough that workers have work from one update to the next at 60 a second, few enough that a turn of the
// eye is not answered late.
constexpr std::size_t kDepthPerWorker = 8;

LoadQueue::Clock::duration pause_after(int tries) {
  return std::min<LoadQueue::Clock::duration>(kFirstPause * (1 << std::min(tries, 8)), kLongestPause);
}

}  // namespace

LoadQueue::LoadQueue(TileTable& table, TileSource source, int workers, int tile_size)
    : table_(table),
      depth_(kDepthPerWorker * static_cast<std::size_t>(workers)),
      loader_(std::move(source), workers, tile_size) {}

std::vector<LoadQueue::Failure> LoadQueue::receive(std::uint64_t limit_bytes, Clock::time_point now) {
  std::vector<Failure> failures;
  for (LoadResult& result : loader_.take(limit_bytes)) {
    const TileKey key = key_of(result.entry);
    if (!result.tile && result.stopped) {
      table_.stop(key);
      continue;
    }
    count(result, now);
    if (result.tile) {
      table_.arrive(key, std::move(*result.tile));
    } else if (result.tile.error().code == ErrorCode::failed) {
      const int tries = table_.fail(key, pause_after(table_.tries(key)), now);
      const bool is_wanted = table_.state(key) == TileState::pausing;
      if (is_wanted && tries == kReportedTries) failures.push_back({result.entry, result.tile.error()});
    } else {
      table_.set_damaged(key);
      failures.push_back({result.entry, result.tile.error()});
    }
  }
  return failures;
}

void LoadQueue::count(const LoadResult& result, Clock::time_point now) {
  if (!result.tile) {
    ++counts_.reads_failed;
    return;
  }
  ++counts_.tiles_loaded;
  counts_.bytes_loaded += result.entry.bytes;
  const TileKey key = key_of(result.entry);
  if (table_.state(key) == TileState::stale) {
    ++counts_.tiles_stale;
  } else {
    const std::chrono::duration<double, std::milli> latency = now - table_.wanted_since(key);
    latency_ms_.add(latency.count());
  }
}

void LoadQueue::set_wanted(std::span<const IndexEntry> wanted, Clock::time_point now) {
  table_.set_wanted(wanted, now);
  const auto is_stale = [this](const TileKey& key) { return table_.state(key) == TileState::stale; };
  for (const TileKey& key : loader_.withdraw(is_stale)) {
    table_.withdraw(key);
    ++counts_.tiles_withdrawn;
  }
}

void LoadQueue::submit(const IndexEntry& entry) {
  assert(!is_full());
  table_.submit(key_of(entry));
  loader_.submit(entry);
}

void LoadQueue::add_to(PagingStats& stats) const {
  stats.tiles_loaded = counts_.tiles_loaded;
  stats.bytes_loaded = counts_.bytes_loaded;
  stats.tiles_stale = counts_.tiles_stale;
  stats.tiles_withdrawn = counts_.tiles_withdrawn;
  stats.reads_failed = counts_.reads_failed;
  stats.in_flight_bytes = table_.bytes_under_way();
  stats.latency_ms = latency_ms_.summary();
}

}  // namespace cairn
