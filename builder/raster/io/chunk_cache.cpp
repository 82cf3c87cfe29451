#include "builder/raster/io/chunk_cache.h"

#include <algorithm>
#include <utility>

namespace cairn {

Result<ChunkCache::Bytes> ChunkCache::get(Key key, const Load& load) {
  if (Bytes found = find_or_claim(key)) return found;
  Result<Chunk> loaded = load();
  const Bytes bytes = loaded ? shared(std::move(*loaded)) : nullptr;
  keep(key, bytes);
  if (!bytes) return loaded.error();
  return bytes;
}

ChunkCache::Bytes ChunkCache::find_or_claim(Key key) {
  std::unique_lock lock(mutex_);
  for (;;) {
    const auto [entry, absent] = entries_.try_emplace(key);
    if (absent) return nullptr;
    if (entry->second.bytes) {
      use_.splice(use_.begin(), use_, entry->second.use);
      return entry->second.bytes;
    }
    decoded_.wait(lock);
  }
}

void ChunkCache::keep(Key key, const Bytes& bytes) {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(key);
  if (!bytes || bytes->size() > byte_limit_) {
    entries_.erase(entry);
  } else {
    use_.push_front(key);
    entry->second = {bytes, use_.begin()};
    bytes_ += bytes_of(entry->second);
    evict_for(bytes->size());
  }
  decoded_.notify_all();
}

// Leaves room for the spares, which will be as large as the newest.
void ChunkCache::evict_for(std::size_t newest) {
  const std::size_t limit = byte_limit_ - (may_spare(newest) ? kSpares * newest : 0);
  while (bytes_ > limit) {
    const auto oldest = entries_.find(use_.back());
    bytes_ -= bytes_of(oldest->second);
    entries_.erase(oldest);
    use_.pop_back();
  }
}

ChunkCache::Bytes ChunkCache::shared(Chunk&& chunk) {
  return {new Chunk(std::move(chunk)), [this](Chunk* unused) {
            set_aside(std::move(*unused));
            delete unused;
          }};
}

void ChunkCache::set_aside(Chunk&& chunk) {
  if (!may_spare(chunk.size())) return;
  const std::lock_guard lock(spares_mutex_);
  if (spares_.size() == kSpares) spares_.erase(spares_.begin());
  spares_.push_back(std::move(chunk));
}

ChunkCache::Chunk ChunkCache::room_for(std::size_t bytes) {
  const std::lock_guard lock(spares_mutex_);
  const auto spare =
      std::find_if(spares_.begin(), spares_.end(), [&](const Chunk& chunk) { return chunk.size() == bytes; });
  if (spare == spares_.end()) return Chunk(bytes);
  Chunk room = std::move(*spare);
  spares_.erase(spare);
  return room;
}

}  // namespace cairn
