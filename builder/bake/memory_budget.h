#pragma once

#include <cstddef>

namespace cairn {

/// What a bake takes memory for besides what it keeps of its sources.
struct MemoryNeeds {
  int threads = 1;
  int tile_size = 513;
  bool with_imagery = false;
  bool with_projected_heights = false;
  bool with_gdal = false;  ///< its own cache of blocks
};

/// What is left of `memory_bytes` for the caches of the sources: what the program holds by now, the tiles in
/// flight and the tree above them come first. Never less than 8 MiB. To be asked once the sources are open,
/// as libraries that are loaded for them count.
std::size_t cache_within(std::size_t memory_bytes, const MemoryNeeds& needs);

/// The least that a bake can stay under, whatever its sources.
std::size_t least_memory(int threads, int tile_size, bool with_imagery);

/// Makes the process's allocator keep what is freed, up to 16 MiB a thread: a tile's images are as large
/// as the last one's, and pages from the system cost as much time as filling them.
void keep_freed_memory();

/// Hands back to the system what is freed: large blocks stay with the allocator otherwise, where another
/// thread's allocations cannot use them.
void release_freed_memory();

/// The most that the program has held so far, in bytes, as the kernel counts it (VmHWM).
std::size_t peak_resident_bytes();

}  // namespace cairn
