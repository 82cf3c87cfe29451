#pragma once

#include <cstdint>
#include <map>

#include "cairn/build_options.h"
#include "cairn/geo.h"
#include "cairn/status.h"

namespace cairn {

/// What a bake will do, before any post is read.
struct DryRun {
  int tile_size = 0;
  int top = 0;
  int finest = 0;
  double error_bound_m = 0;
  double quantum_m = 0;
  GeoBounds bounds;
  std::map<int, std::uint64_t> tiles;          ///< by level, before pruning leaves any out
  std::map<int, std::uint64_t> texture_tiles;  ///< of the imagery layer, likewise
  std::uint64_t samples = 0;                   ///< of the finest tiles of heights
  std::uint64_t estimated_bytes = 0;           ///< of the pack, from a few tiles baked on trial
  double estimated_seconds = 0;                ///< likewise
  std::uint64_t memory_bytes = 0;              ///< what the bake will hold at most
};

/// Steps 1 and 2 of build(), and some units of each layer baked on trial, spread evenly over the plan: bytes
/// and seconds of all layers are a multiple of theirs.
Result<DryRun> dry_run(const BuildOptions& options);

}  // namespace cairn
