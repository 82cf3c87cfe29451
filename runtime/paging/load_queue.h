#pragma once

#include <chrono>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/paging/frame_stats.h"
#include "runtime/paging/tile_loader.h"
#include "runtime/paging/tile_table.h"

namespace cairn {

/// So many reads in a row have to fail before a tile counts as failing.
inline constexpr int kReportedTries = 5;

/// The owner's side of the loader: gives wanted tiles to it, and puts what comes back into the table. A tile
/// whose read fails is read again for as long as it is wanted, after 20, 40, 80 ms and so on, 5 s at most; a
/// damaged one is not. One thread only: the owner's.
class LoadQueue {
 public:
  using Clock = TileTable::Clock;

  /// `table` must outlive the queue.
  LoadQueue(TileTable& table, TileSource source, int workers, int tile_size);

  struct Failure {
    IndexEntry entry;
    Error error;  ///< ErrorCode::failed: kReportedTries reads in a row have failed, and the tile is pausing
  };
  /// Takes in what has come, up to the limit of decoded bytes. Returns the tiles that cannot be had: those
  /// are damaged, or pausing.
  std::vector<Failure> receive(std::uint64_t limit_bytes, Clock::time_point now);

  /// Says what is wanted now; of all else, what no worker has begun is withdrawn.
  void set_wanted(std::span<const IndexEntry> wanted, Clock::time_point now);
  bool is_full() const { return table_.under_way() >= depth_; }
  /// REQUIRES: the table says that the tile is due; !is_full().
  void submit(const IndexEntry& entry);

  void add_to(PagingStats& stats) const;

 private:
  void count(const LoadResult& result, Clock::time_point now);

  TileTable& table_;
  const std::size_t depth_;
  PagingStats counts_;
  RecentSamples latency_ms_;
  TileLoader loader_;
};

}  // namespace cairn
