#include "runtime/paging/load_queue.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace cairn {
namespace {

constexpr int kReportedTries = 5;
constexpr std::chrono::milliseconds kFirstPause{20};
constexpr std::chrono::milliseconds kLongestPause{5000};
// Enough that workers have work from one update to the next at 60 a second, few enough that a turn of the
// eye is not answered late.
constexpr std::size_t kDepthPerWorker = 8;

}  // namespace

LoadQueue::LoadQueue(TileSource source, int workers, int tile_size)
    : tile_size_(tile_size),
      depth_(kDepthPerWorker * static_cast<std::size_t>(workers)),
      loader_(std::move(source), workers, tile_size) {}

std::vector<LoadQueue::Delivery> LoadQueue::deliver(std::uint64_t limit_bytes, Clock::time_point now) {
  std::vector<Delivery> deliveries;
  for (LoadResult& result : loader_.take(limit_bytes)) {
    const auto found = requests_.find(key_of(result.entry));
    assert(found != requests_.end() && found->second.under_way);
    Request& request = found->second;
    leave(request);
    if (!result.tile && result.stopped) continue;
    count(result, request, now);
    if (!result.tile && result.tile.error().code == ErrorCode::failed) {
      pause(request, now);
      if (request.tries != kReportedTries) continue;
    } else {
      requests_.erase(found);
    }
    deliveries.push_back({result.entry, std::move(result.tile)});
  }
  return deliveries;
}

void LoadQueue::count(const LoadResult& result, const Request& request, Clock::time_point now) {
  if (!result.tile) {
    ++counts_.reads_failed;
    return;
  }
  ++counts_.tiles_loaded;
  counts_.bytes_loaded += result.entry.bytes;
  if (!request.wanted) ++counts_.tiles_stale;
  if (request.wanted) latency_ms_.add(std::chrono::duration<double, std::milli>(now - request.since).count());
}

void LoadQueue::pause(Request& request, Clock::time_point now) const {
  const auto pause = kFirstPause * (1 << std::min(request.tries, 8));
  request.not_before = now + std::min<Clock::duration>(pause, kLongestPause);
  ++request.tries;
}

bool LoadQueue::only_failing() const {
  return !requests_.empty() && std::all_of(requests_.begin(), requests_.end(), [](const auto& item) {
    return item.second.tries >= kReportedTries;
  });
}

void LoadQueue::leave(Request& request) {
  request.under_way = false;
  --under_way_;
  bytes_under_way_ -= std::exchange(request.bound, 0);
}

void LoadQueue::set_wanted(const std::vector<IndexEntry>& wanted, Clock::time_point now) {
  for (auto& [key, request] : requests_) request.wanted = false;
  for (const IndexEntry& entry : wanted) {
    requests_.try_emplace(key_of(entry), Request{now, now}).first->second.wanted = true;
  }
  const auto is_stale = [this](const TileKey& key) { return !requests_.at(key).wanted; };
  for (const TileKey& key : loader_.withdraw(is_stale)) {
    leave(requests_.at(key));
    ++counts_.tiles_withdrawn;
  }
  std::erase_if(requests_, [](const auto& item) { return !item.second.wanted && !item.second.under_way; });
}

bool LoadQueue::is_waiting(const TileKey& key, Clock::time_point now) const {
  const auto found = requests_.find(key);
  return found != requests_.end() && found->second.wanted && !found->second.under_way &&
         now >= found->second.not_before;
}

void LoadQueue::submit(const IndexEntry& entry) {
  Request& request = requests_.at(key_of(entry));
  assert(!request.under_way && !is_full());
  request.under_way = true;
  request.bound = decoded_bytes_bound(entry, tile_size_);
  ++under_way_;
  bytes_under_way_ += request.bound;
  loader_.submit(entry);
}

void LoadQueue::add_to(PagingStats& stats) const {
  stats.tiles_loaded = counts_.tiles_loaded;
  stats.bytes_loaded = counts_.bytes_loaded;
  stats.tiles_stale = counts_.tiles_stale;
  stats.tiles_withdrawn = counts_.tiles_withdrawn;
  stats.reads_failed = counts_.reads_failed;
  stats.in_flight_bytes = bytes_under_way_;
  stats.latency_ms = latency_ms_.summary();
}

}  // namespace cairn
