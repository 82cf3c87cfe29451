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
#include <unordered_map>
#include <vector>

#include "cairn/read_tile.h"
#include "cairn/status.h"

namespace cairn {

/// What became of a request.
struct LoadResult {
  IndexEntry entry;
  Result<LoadedTile> tile;
  bool stopped = false;  ///< it was asked to stop, so that an error says nothing of the tile
};

/// Reads and decodes tiles in the order in which they were submitted: on worker threads, or by an
/// asynchronous source. Every submitted tile that is not withdrawn is handed out once, checked.
///
/// Threads: submit, withdraw and take belong to one thread, the owner. Workers take immutable requests from
/// one queue and give results through another; each has a mutex, which nobody holds while reading.
class TileLoader {
 public:
  /// `workers` threads for a ReadTile, none for a RequestTile. REQUIRES: workers >= 1.
  TileLoader(TileSource source, int workers, int tile_size);
  /// Waits for the reads of the worker threads in progress; asks asynchronous ones to stop and waits for
  /// none.
  ~TileLoader();
  TileLoader(const TileLoader&) = delete;
  TileLoader& operator=(const TileLoader&) = delete;

  void submit(const IndexEntry& entry);

  /// Takes back the requests that no worker has begun and `stale` says yes to, and returns them. Asynchronous
  /// reads that are stale are asked to stop; take() returns them when they have.
  std::vector<TileKey> withdraw(const std::function<bool(const TileKey&)>& stale);

  /// Returns finished loads, the oldest first, until their decoded bytes reach the limit; one at least if
  /// there is one.
  std::vector<LoadResult> take(std::uint64_t limit_bytes);

 private:
  class Results;
  class Delivery;

  void work(const std::stop_token& stop, const ReadTile& read);
  void start(const RequestTile& request, const IndexEntry& entry);

  const TileSource source_;
  const int tile_size_;
  const std::shared_ptr<Results> results_;  // lives on with asynchronous reads that have not ended
  std::unordered_map<TileKey, std::stop_source> started_;  // asynchronous reads, until they are taken

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::deque<IndexEntry> queue_;       // guarded by mutex_
  std::vector<std::jthread> workers_;  // last, so that they end before what they use
};

}  // namespace cairn
