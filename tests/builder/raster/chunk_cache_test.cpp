// ChunkCache with many threads: one load a chunk, right bytes, and no more memory than it may keep.

#include "builder/raster/io/chunk_cache.h"

#include <atomic>
#include <chrono>
#include <random>
#include <thread>
#include <vector>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

constexpr std::size_t kChunkBytes = 4096;

ChunkCache::Chunk chunk_of(ChunkCache& cache, std::uint64_t key) {
  ChunkCache::Chunk chunk = cache.room_for(kChunkBytes);
  for (std::byte& b : chunk) b = static_cast<std::byte>(key * 31);
  return chunk;
}

bool is_chunk_of(const ChunkCache::Bytes& bytes, std::uint64_t key) {
  if (bytes->size() != kChunkBytes) return false;
  for (const std::byte b : *bytes) {
    if (b != static_cast<std::byte>(key * 31)) return false;
  }
  return true;
}

template <class Work>
void run_threads(int count, const Work& work) {
  std::vector<std::thread> threads;
  for (int t = 0; t < count; ++t) threads.emplace_back([&work, t] { work(t); });
  for (auto& thread : threads) thread.join();
}

}  // namespace

TEST_CASE("threads that ask for one chunk at once share one load") {
  ChunkCache cache(1 << 20);
  std::atomic<int> loads = 0, wrong = 0;
  run_threads(8, [&](int) {
    for (std::uint64_t key = 0; key < 20; ++key) {
      const auto bytes = cache.get(key, [&]() -> Result<ChunkCache::Chunk> {
        ++loads;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        return chunk_of(cache, key);
      });
      if (!bytes.ok() || !is_chunk_of(*bytes, key)) ++wrong;
    }
  });
  CHECK(wrong == 0);
  CHECK(loads == 20);
}

TEST_CASE("under eviction by many threads every chunk handed out is right, also past its eviction") {
  ChunkCache cache(24 * kChunkBytes);
  std::atomic<int> wrong = 0;
  run_threads(8, [&](int t) {
    std::mt19937 random(static_cast<std::mt19937::result_type>(t));
    std::vector<std::pair<std::uint64_t, ChunkCache::Bytes>> held;
    for (int i = 0; i < 3000; ++i) {
      const std::uint64_t key = random() % 64;
      const auto bytes = cache.get(key, [&]() -> Result<ChunkCache::Chunk> { return chunk_of(cache, key); });
      if (!bytes.ok()) {
        ++wrong;
        continue;
      }
      held.emplace_back(key, *bytes);
      if (held.size() > 5) held.erase(held.begin());
      for (const auto& [held_key, held_bytes] : held) wrong += is_chunk_of(held_bytes, held_key) ? 0 : 1;
    }
  });
  CHECK(wrong == 0);
}

TEST_CASE("a load that fails is reported to its thread, and another one loads anew") {
  ChunkCache cache(1 << 20);
  std::atomic<int> loads = 0, errors = 0, right = 0;
  run_threads(8, [&](int) {
    const auto bytes = cache.get(7, [&]() -> Result<ChunkCache::Chunk> {
      if (++loads <= 3) return failed("a bad strip");
      return chunk_of(cache, 7);
    });
    if (!bytes.ok()) {
      ++errors;
    } else if (is_chunk_of(*bytes, 7)) {
      ++right;
    }
  });
  CHECK(errors == 3);
  CHECK(right == 5);
  CHECK(loads == 4);
}

TEST_CASE("the cache keeps the chunks used last, up to its limit, and hands out a larger one unkept") {
  ChunkCache cache(32 * kChunkBytes);
  int loads = 0;
  const auto get = [&](std::uint64_t key) {
    return cache.get(key, [&]() -> Result<ChunkCache::Chunk> {
      ++loads;
      return chunk_of(cache, key);
    });
  };
  for (std::uint64_t key = 0; key < 100; ++key) REQUIRE(get(key).ok());
  CHECK(loads == 100);
  for (std::uint64_t key = 80; key < 100; ++key) REQUIRE(get(key).ok());
  CHECK(loads == 100);
  REQUIRE(get(0).ok());
  CHECK(loads == 101);

  const auto large = cache.get(1000, [&]() -> Result<ChunkCache::Chunk> {
    ++loads;
    return ChunkCache::Chunk(64 * kChunkBytes);
  });
  REQUIRE(large.ok());
  CHECK((*large)->size() == 64 * kChunkBytes);
  REQUIRE(cache
              .get(1000,
                   [&]() -> Result<ChunkCache::Chunk> {
                     ++loads;
                     return ChunkCache::Chunk(64 * kChunkBytes);
                   })
              .ok());
  CHECK(loads == 103);
}

}  // namespace cairn
