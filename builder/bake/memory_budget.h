#pragma once

#include <cstddef>

namespace cairn {

/// How a bake divides its memory.
struct MemoryBudget {
  std::size_t cache_bytes = 0;  ///< decoded strips and tiles of the sources
};

/// What the program itself, the tiles in flight and the tree above them need comes first; the sources' caches
/// get the rest, and never less than 8 MiB.
MemoryBudget divide_memory(std::size_t memory_bytes, int threads, int tile_size, bool with_imagery);

/// The least that a bake can promise to stay under.
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
