#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "cairn/build_options.h"
#include "cairn/progress.h"
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

/// What a bake did.
struct BuildReport {
  std::string metadata_json;       ///< as it is in the pack
  bool within_error_bound = true;  ///< false only with BuildOptions::allow_error
  std::string warning;             ///< empty where all is well
  std::uint64_t samples = 0;       ///< of the finest tiles of heights
  std::uint64_t texels = 0;        ///< of the finest tiles of imagery
  std::uint64_t file_bytes = 0;
  double seconds = 0;
  int threads = 0;
  bool resumed = false;
};

/// START HERE: from DEMs and images to a verified pack, in numbered steps.
///
/// The same inputs and options give the same bytes, whatever the threads and the memory, also after an
/// interruption that `options.resume` goes on from. The target appears when it is whole and its accuracy is
/// measured, or not at all.
Result<BuildReport> build(const BuildOptions& options, const ProgressCallback& progress);

/// Steps 1 and 2 of build(), and a trial of a few tiles.
Result<DryRun> dry_run(const BuildOptions& options);

}  // namespace cairn
