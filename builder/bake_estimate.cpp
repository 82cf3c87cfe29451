#include "cairn/bake_estimate.h"

#include <algorithm>
#include <chrono>
#include <utility>
#include <vector>

#include "builder/bake/bake_target.h"
#include "builder/bake/thread_arena.h"
#include "builder/bake_plan.h"
#include "builder/heights/height_leaf.h"
#include "format/codec.h"
#include "format/height_block.h"

namespace cairn {
namespace {

constexpr std::size_t kTrials = 8;

// Puts what the whole will take into `dry`.
Status estimate(const Mosaic& mosaic, const HeightPlan& plan, VoidMode voids, int threads, DryRun& dry) {
  const std::vector<TileId> units = plan.tree().units();
  const std::size_t trials = std::min(kTrials, units.size());
  const auto start = std::chrono::steady_clock::now();
  std::uint64_t bytes = 0;
  for (std::size_t t = 0; t < trials; ++t) {
    const std::vector<TileId> leaves = plan.tree().leaves(units[t * units.size() / trials]);
    auto leaf = sample_leaf(mosaic, plan, leaves[leaves.size() / 2], voids);
    if (!leaf) return leaf.error();
    const HeightNode node = measure_leaf(mosaic, plan, std::move(*leaf));
    bytes += encode_height_block(node.tile, default_height_codec()).size();
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  std::uint64_t tiles = 0;
  for (const auto& [level, count] : dry.tiles) tiles += count;
  const std::uint64_t leaves = plan.tree().leaf_count();
  const auto intervals = static_cast<std::uint64_t>(plan.tile_size() - 1);
  dry.samples = leaves * intervals * intervals;
  dry.estimated_bytes = bytes * tiles / trials;
  dry.estimated_seconds =
      seconds * static_cast<double>(leaves) / static_cast<double>(trials * static_cast<std::size_t>(threads));
  return {};
}

}  // namespace

Result<DryRun> dry_run(const BuildOptions& options) {
  return with_threads(options.session.threads, [&](int threads) -> Result<DryRun> {
    if (auto status = check_target_is_no_input(options.session.target, files_of(options)); !status)
      return status.error();
    const auto layers = plan_bake(options, threads);
    if (!layers) return layers.error();
    DryRun dry;
    dry.tile_size = options.grid.tile_size;
    dry.bounds = layers->bounds();
    dry.memory_bytes = options.session.memory_bytes;
    if (layers->imagery) dry.texture_tiles = layers->imagery_tree->tiles_by_level();
    if (!layers->heights) return dry;
    const HeightPlan& plan = *layers->plan;
    dry.top = plan.top();
    dry.finest = plan.finest();
    dry.error_bound_m = plan.error_bound_m();
    dry.quantum_m = plan.quantum_m();
    dry.tiles = plan.tree().tiles_by_level();
    if (auto status = estimate(*layers->heights, plan, options.heights.voids, threads, dry); !status)
      return status.error();
    return dry;
  });
}

}  // namespace cairn
