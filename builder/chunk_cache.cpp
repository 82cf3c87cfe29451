#include "builder/chunk_cache.h"

#include <utility>

namespace cairn {

Result<ChunkCache::Bytes> ChunkCache::get(std::uint64_t key, const Load& load) {
  if (Bytes found = find_or_claim(key)) return found;
  Result<Chunk> loaded = load();
  Bytes bytes = loaded ? std::make_shared<const Chunk>(std::move(*loaded)) : nullptr;
  keep(key, bytes);
  if (!bytes) return loaded.error();
  return bytes;
}

ChunkCache::Bytes ChunkCache::find_or_claim(std::uint64_t key) {
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

void ChunkCache::keep(std::uint64_t key, const Bytes& bytes) {
  const std::lock_guard lock(mutex_);
  const auto entry = entries_.find(key);
  if (!bytes || bytes->size() > byte_limit_) {
    entries_.erase(entry);
  } else {
    use_.push_front(key);
    entry->second = {bytes, use_.begin()};
    bytes_ += bytes->size();
    evict_to_limit();
  }
  decoded_.notify_all();
}

void ChunkCache::evict_to_limit() {
  while (bytes_ > byte_limit_) {
    const auto oldest = entries_.find(use_.back());
    bytes_ -= oldest->second.bytes->size();
    entries_.erase(oldest);
    use_.pop_back();
  }
}

}  // namespace cairn
