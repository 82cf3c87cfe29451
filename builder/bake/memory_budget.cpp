#include "builder/bake/memory_budget.h"

#include <algorithm>
#include <fstream>
#include <string>

#include <malloc.h>

namespace cairn {
namespace {

constexpr std::size_t kMiB = std::size_t{1} << 20;
constexpr std::size_t kProgram = 24 * kMiB;     // code, libraries and small things: an idle start shows 7 MiB
constexpr std::size_t kGrowth = 12 * kMiB;      // of these beyond what is there once the sources are open
constexpr std::size_t kGdalBlocks = 16 * kMiB;  // see gdal_source.cpp
constexpr std::size_t kLeastCache = 8 * kMiB;

// Tiles alive at once, in a thread: a leaf's samples and posts, its pyramid, the blocks of two units. Texels
// take more than samples: 8 bytes each, and 16 while pixels are resampled.
// Placed posts take 24 bytes each, and may be as many as the samples.
std::size_t for_thread(const MemoryNeeds& needs) {
  const std::size_t bytes = needs.with_projected_heights || needs.with_imagery ? 96 : 64;
  return static_cast<std::size_t>(needs.tile_size) * static_cast<std::size_t>(needs.tile_size) * bytes;
}

// The serial end: a tile for each level up to the whole Earth.
std::size_t for_tree(int tile_size) {
  return static_cast<std::size_t>(tile_size) * static_cast<std::size_t>(tile_size) * 5 * 12;
}

std::size_t for_tiles(const MemoryNeeds& needs) {
  return static_cast<std::size_t>(needs.threads) * for_thread(needs) + for_tree(needs.tile_size);
}

// Of /proc/self/status, in bytes.
std::size_t status_bytes(const char* name) {
  std::ifstream status("/proc/self/status");
  std::string word;
  std::size_t kibibytes = 0;
  while (status >> word && word != name) {
  }
  status >> kibibytes;
  return kibibytes * 1024;
}

}  // namespace

std::size_t cache_within(std::size_t memory_bytes, const MemoryNeeds& needs) {
  const std::size_t program = std::max(kProgram, status_bytes("VmRSS:") + kGrowth);
  const std::size_t needed = program + for_tiles(needs) + (needs.with_gdal ? kGdalBlocks : 0);
  return std::max(kLeastCache, memory_bytes > needed ? memory_bytes - needed : 0);
}

std::size_t least_memory(int threads, int tile_size, bool with_imagery) {
  return kProgram + for_tiles({threads, tile_size, with_imagery, false, false}) + kLeastCache;
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
  return status_bytes("VmHWM:");
}

}  // namespace cairn
