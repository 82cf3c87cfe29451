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

#include "builder/page_allocator.h"
#include "format/status.h"

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
  /// limit is handed out and not kept.
  Result<Bytes> get(std::uint64_t key, const Load& load);

 private:
  struct Entry {
    Bytes bytes;  // null while a thread decodes it
    std::list<std::uint64_t>::iterator use;
  };

  Bytes find_or_claim(std::uint64_t key);
  void keep(std::uint64_t key, const Bytes& bytes);
  void evict_to_limit();

  std::size_t byte_limit_;
  std::mutex mutex_;
  std::condition_variable decoded_;
  std::unordered_map<std::uint64_t, Entry> entries_;
  std::list<std::uint64_t> use_;  // most recent first; complete chunks only
  std::size_t bytes_ = 0;
};

}  // namespace cairn
