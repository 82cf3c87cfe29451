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

  /// Which chunk: its number, and where several share the cache, whose it is.
  struct Key {
    Key(std::uint64_t number) : chunk(number) {}
    Key(std::uint64_t owner_of_chunk, std::uint64_t number) : owner(owner_of_chunk), chunk(number) {}
    friend bool operator==(const Key&, const Key&) = default;

    std::uint64_t owner = 0;
    std::uint64_t chunk = 0;
  };

  explicit ChunkCache(std::size_t byte_limit) : byte_limit_(byte_limit) {}

  /// Not while other threads use the cache. What it holds goes as more comes in.
  void set_byte_limit(std::size_t bytes) { byte_limit_ = bytes; }

  /// The chunk, loaded if it is not there. Chunks in use stay alive past their eviction; one larger than the
  /// limit is handed out and not kept. REQUIRES: nothing handed out outlives the cache.
  Result<Bytes> get(Key key, const Load& load);

  /// Bytes without values for a load to fill: those of an evicted chunk of that size, where there are any.
  /// The system takes longer to give pages than a load to fill them.
  Chunk room_for(std::size_t bytes);

 private:
  struct Entry {
    Bytes bytes;  // null while a thread decodes it
    std::list<Key>::iterator use;
  };
  struct HashKey {
    std::size_t operator()(const Key& key) const {
      return std::hash<std::uint64_t>()(key.chunk ^ (key.owner << 48) ^ (key.chunk >> 29));
    }
  };

  static std::size_t bytes_of(const Entry& entry) { return entry.bytes->size() + kEntryBytes; }
  Bytes find_or_claim(Key key);
  void keep(Key key, const Bytes& bytes);
  void evict_for(std::size_t newest);
  Bytes shared(Chunk&& chunk);
  bool may_spare(std::size_t bytes) const { return bytes <= byte_limit_ / (8 * kSpares); }
  void set_aside(Chunk&& chunk);

  static constexpr std::size_t kSpares = 2;
  static constexpr std::size_t kEntryBytes = 160;  // of the tables, so that empty chunks have a limit, too
  std::size_t byte_limit_;
  std::mutex spares_mutex_;    // taken last
  std::vector<Chunk> spares_;  // what nobody uses any more, the latest last; entries become spares to the end
  std::mutex mutex_;
  std::condition_variable decoded_;
  std::unordered_map<Key, Entry, HashKey> entries_;
  std::list<Key> use_;  // most recent first; complete chunks only
  std::size_t bytes_ = 0;
};

}  // namespace cairn
