#include "builder/bake/memory_budget.h"

#include <algorithm>
#include <fstream>
#include <string>

#include <malloc.h>

namespace cairn {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;
constexpr std::size_t kProgram = 24 * kMiB;  // code, libraries and small things: an idle start shows 7 MiB
constexpr std::size_t kLeastCache = 8 * kMiB;

// Tiles alive at once, in a thread: a leaf's samples and posts, its pyramid, the blocks of two units. Texels
// take more than samples: 8 bytes each, and 16 while pixels are resampled.
std::size_t for_thread(int tile_size, bool with_imagery) {
  const std::size_t bytes = with_imagery ? 96 : 64;
  return static_cast<std::size_t>(tile_size) * static_cast<std::size_t>(tile_size) * bytes;
}

// The serial end: a tile for each level up to the whole Earth.
std::size_t for_tree(int tile_size) {
  return static_cast<std::size_t>(tile_size) * static_cast<std::size_t>(tile_size) * 5 * 12;
}

std::size_t fixed(int threads, int tile_size, bool with_imagery) {
  return kProgram + static_cast<std::size_t>(threads) * for_thread(tile_size, with_imagery) +
         for_tree(tile_size);
}

}  // namespace

MemoryBudget divide_memory(std::size_t memory_bytes, int threads, int tile_size, bool with_imagery) {
  const std::size_t needed = fixed(threads, tile_size, with_imagery);
  return {std::max(kLeastCache, memory_bytes > needed ? memory_bytes - needed : 0)};
}

std::size_t least_memory(int threads, int tile_size, bool with_imagery) {
  return fixed(threads, tile_size, with_imagery) + kLeastCache;
}

void keep_freed_memory() {
  ::mallopt(M_MMAP_THRESHOLD, static_cast<int>(4 * kMiB));
  ::mallopt(M_TRIM_THRESHOLD, static_cast<int>(16 * kMiB));
}

void release_freed_memory() {
  ::malloc_trim(0);
}

std::size_t peak_resident_bytes() {
  // Not getrusage(): its figure outlives exec(), and is that of a larger program that started this one.
  std::ifstream status("/proc/self/status");
  std::string word;
  std::size_t kibibytes = 0;
  while (status >> word && word != "VmHWM:") {
  }
  status >> kibibytes;
  return kibibytes * 1024;
}

}  // namespace cairn
