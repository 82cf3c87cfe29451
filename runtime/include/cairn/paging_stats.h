#pragma once

#include <cstddef>
#include <cstdint>

namespace cairn {

/// A summary of measurements; all zero if there are none.
struct Summary {
  std::size_t count = 0;
  double min = 0;
  double max = 0;
  double mean = 0;
  double p50 = 0;  ///< percentiles by nearest rank: the smallest measurement that p % do not exceed
  double p95 = 0;
  double p99 = 0;
};

/// Counts of the paging since the terrain was opened.
struct PagingStats {
  std::uint64_t updates = 0;
  std::uint64_t moves = 0;            ///< changes of the scene map
  std::uint64_t tiles_loaded = 0;     ///< decoded and delivered
  std::uint64_t bytes_loaded = 0;     ///< of their blocks, as stored
  std::uint64_t bytes_unseen = 0;     ///< of these, the ones of tiles that no view has seen so far
  std::uint64_t tiles_stale = 0;      ///< of those, no longer needed when they arrived
  std::uint64_t tiles_withdrawn = 0;  ///< requests taken back before a worker began them
  std::uint64_t reads_failed = 0;
  std::uint64_t tiles_damaged = 0;
  std::uint64_t updates_behind = 0;   ///< that drew another map than the camera's, because tiles were missing
  std::uint64_t holes = 0;            ///< drawn tiles without the data that the pack has for them; must be 0
  std::uint64_t resident_bytes = 0;   ///< now
  std::uint64_t in_flight_bytes = 0;  ///< now: what the requests under way will need at most
  std::uint64_t objects_resident = 0;  ///< now: in the tiles of objects that are listed
  std::uint64_t models_resident = 0;   ///< now; each model is in memory once
  std::uint64_t model_bytes = 0;       ///< of these
  std::uint64_t models_loaded = 0;     ///< reads of a model
  Summary latency_ms;                  ///< from the first plan that needed a tile to its delivery
};

}  // namespace cairn
