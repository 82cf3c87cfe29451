#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <thread>
#include <vector>

#include "cairn/loaded_tile.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// The one that programs use; others stand in for slow and failing disks in the tests.
ReadTile read_from(std::shared_ptr<const PackReader> pack);

/// What became of a request.
struct LoadResult {
  IndexEntry entry;
  Result<LoadedTile> tile;
};

/// Worker threads that read and decode tiles, in the order in which they were submitted.
///
/// Threads: submit, withdraw and take belong to one thread, the owner. Workers take immutable requests from
/// one queue and give results through another; both are under mutex_, which nobody holds while reading.
class TileLoader {
 public:
  /// REQUIRES: workers >= 1.
  TileLoader(ReadTile read, int workers);
  /// Waits for the reads in progress; what is queued is dropped.
  ~TileLoader();
  TileLoader(const TileLoader&) = delete;
  TileLoader& operator=(const TileLoader&) = delete;

  void submit(const IndexEntry& entry);

  /// Takes back the requests that no worker has begun and `stale` says yes to, and returns them.
  std::vector<TileKey> withdraw(const std::function<bool(const TileKey&)>& stale);

  /// Finished loads, the oldest first, until their decoded bytes reach the limit; one at least if there is
  /// one.
  std::vector<LoadResult> take(std::uint64_t limit_bytes);

 private:
  void work(const std::stop_token& stop);

  const ReadTile read_;
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::deque<IndexEntry> queue_;       // guarded by mutex_
  std::deque<LoadResult> finished_;    // guarded by mutex_
  std::vector<std::jthread> workers_;  // last, so that they end before what they use
};

}  // namespace cairn
