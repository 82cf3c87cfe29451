#pragma once

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "builder/raster/io/page_allocator.h"
#include "cairn/status.h"

namespace cairn {

/// Decoded strips or tiles of a file, the most recently used of them, up to a number of bytes. Threads that
/// want a chunk which another one is decoding wait for it rather than decode it again.
class ChunkCache {
 public:
  using Chunk = std::vector<std::byte, PageAllocator<std::byte>>;
  using Bytes = std::shared_ptr<const Chunk>;
  using Load = std::function<Result<Chunk>()>;

  explicit ChunkCache(std::size_t byte_limit) : byte_limit_(byte_limit) {}

  /// The chunk, loaded if it is not there. Chunks in use stay alive past their eviction; one larger than the
  /// limit is handed out and not kept. REQUIRES: nothing handed out outlives the cache.
  Result<Bytes> get(std::uint64_t key, const Load& load);

  /// Bytes without values for a load to fill: those of an evicted chunk of that size, where there are any.
  /// The system takes longer to give pages than a load to fill them.
  Chunk room_for(std::size_t bytes);

 private:
  struct Entry {
    Bytes bytes;  // null while a thread decodes it
    std::list<std::uint64_t>::iterator use;
  };

  Bytes find_or_claim(std::uint64_t key);
  void keep(std::uint64_t key, const Bytes& bytes);
  void evict_for(std::size_t newest);
  Bytes shared(Chunk&& chunk);
  bool may_spare(std::size_t bytes) const { return bytes <= byte_limit_ / (8 * kSpares); }
  void set_aside(Chunk&& chunk);

  static constexpr std::size_t kSpares = 2;
  std::size_t byte_limit_;
  std::mutex spares_mutex_;    // taken last
  std::vector<Chunk> spares_;  // what nobody uses any more, the latest last; entries become spares to the end
  std::mutex mutex_;
  std::condition_variable decoded_;
  std::unordered_map<std::uint64_t, Entry> entries_;
  std::list<std::uint64_t> use_;  // most recent first; complete chunks only
  std::size_t bytes_ = 0;
};

}  // namespace cairn
