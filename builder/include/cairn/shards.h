#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "cairn/build.h"
#include "cairn/build_options.h"
#include "cairn/progress.h"
#include "cairn/session_options.h"
#include "cairn/status.h"

namespace cairn {

/// Into how many shards a bake is divided.
struct ShardSize {
  std::optional<std::uint64_t> count;  ///< as many as this; some are empty where there are too few tiles
  std::optional<std::uint64_t> bytes;  ///< else so many that a part has about this size
};

/// What a plan came to.
struct PlanReport {
  struct Shard {
    std::uint64_t height_leaves = 0;   ///< finest tiles, before pruning leaves any out
    std::uint64_t texture_leaves = 0;  ///< likewise
    std::uint64_t files = 0;           ///< that it reads
    std::uint64_t file_bytes = 0;      ///< of these
    std::uint64_t estimated_bytes = 0;
    double estimated_seconds = 0;  ///< on all threads of the machine that planned
  };
  std::vector<Shard> shards;
  std::uint64_t files = 0;
  std::uint64_t memory_bytes = 0;  ///< that a shard stays under
};

/// Divides a bake into shards that own whole subtrees of tiles, and writes that as a plan,
/// `options.session`'s target. Every input is read once: hashed, and DEMs searched for voids, since these are
/// filled from all that touches them.
Result<PlanReport> plan_shards(const BuildOptions& options, const ShardSize& size,
                               const ProgressCallback& progress);

/// What the bake of a shard did.
struct ShardReport {
  std::uint64_t units = 0;  ///< subtrees of at most 16 leaves
  std::uint64_t samples = 0;
  std::uint64_t texels = 0;
  std::uint64_t file_bytes = 0;
  double seconds = 0;
  int threads = 0;
  bool resumed = false;
};

/// Bakes one shard of a plan into a part, `session.target`. Of the plan's files those of the shard have to be
/// there, as they were when the plan was made; no other is read. 0 for `session.memory_bytes` stands for the
/// plan's.
Result<ShardReport> bake_shard(const std::filesystem::path& plan, std::size_t shard,
                               const SessionOptions& session, const ProgressCallback& progress);

/// Puts the parts of all shards together, in whatever order they are given. The pack has the bytes of
/// build()'s for the inputs and options that were planned. Of the plan's files those of objects alone are
/// read: places and models, which have to be as they were planned. Memory does not grow with the parts. The
/// error names a part that is missing, given twice, or of another plan.
Result<BuildReport> merge_parts(const std::filesystem::path& plan,
                                const std::vector<std::filesystem::path>& parts,
                                const SessionOptions& session, const ProgressCallback& progress);

/// The remedies for an error that bake_shard() returned for this session.
std::vector<Remedy> remedies_for_shard(const Error& error, const SessionOptions& session);

}  // namespace cairn
