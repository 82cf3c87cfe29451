#pragma once

#include <chrono>
#include <cstdint>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "runtime/paging/frame_stats.h"
#include "runtime/paging/tile_loader.h"

namespace cairn {

/// The owner's side of the loader: what is under way, what waits for another try, and how long it all takes.
/// One thread only: the owner's.
///
/// A tile: (not wanted) → wanted → under way → delivered, or failed → wanted again after a pause. A wanted
/// tile that is not wanted any more is forgotten; one under way is withdrawn if no worker has begun it, and
/// delivered all the same if one has.
class LoadQueue {
 public:
  using Clock = std::chrono::steady_clock;

  LoadQueue(TileSource source, int workers, int tile_size);

  struct Delivery {
    IndexEntry entry;
    Result<LoadedTile> tile;  ///< ErrorCode::failed: five reads in a row have failed, and more will follow
  };
  /// What has come in, up to the limit of decoded bytes. A tile whose read fails is read again for as long as
  /// it is wanted, after 20, 40, 80 ms and so on, 5 s at most; a damaged one is not.
  std::vector<Delivery> deliver(std::uint64_t limit_bytes, Clock::time_point now);

  /// Says what is wanted now; all else is forgotten or withdrawn.
  void set_wanted(const std::vector<IndexEntry>& wanted, Clock::time_point now);

  /// Whether the tile could be submitted now: wanted, not under way, not pausing.
  bool is_waiting(const TileKey& key, Clock::time_point now) const;
  bool is_full() const { return under_way_ >= depth_; }
  /// REQUIRES: is_waiting(key_of(entry)), !is_full().
  void submit(const IndexEntry& entry);

  /// Bytes that the tiles under way will need at most.
  std::uint64_t bytes_under_way() const { return bytes_under_way_; }
  std::size_t size() const { return requests_.size(); }
  /// Whether tiles are wanted, and the last five reads or more of each have failed.
  bool only_failing() const;

  void add_to(PagingStats& stats) const;

 private:
  struct Request {
    Clock::time_point since;
    Clock::time_point not_before;
    int tries = 0;
    bool wanted = true;
    bool under_way = false;
    std::uint64_t bound = 0;  // bytes that it will need at most; known once under way
  };
  using Requests = std::unordered_map<TileKey, Request>;

  void count(const LoadResult& result, const Request& request, Clock::time_point now);
  void pause(Request& request, Clock::time_point now) const;
  void leave(Request& request);

  const int tile_size_;
  const std::size_t depth_;
  Requests requests_;
  std::size_t under_way_ = 0;
  std::uint64_t bytes_under_way_ = 0;
  PagingStats counts_;
  RecentSamples latency_ms_;
  TileLoader loader_;
};

}  // namespace cairn
