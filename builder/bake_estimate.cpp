#include "builder/bake_estimate.h"

#include <algorithm>
#include <chrono>

#include "builder/heights/height_leaf.h"
#include "format/codec.h"
#include "format/height_block.h"

namespace cairn {
namespace {

constexpr std::size_t kTrials = 8;

}  // namespace

Status estimate(const Mosaic& mosaic, const HeightPlan& plan, VoidMode voids, int threads, DryRun& dry) {
  const std::vector<TileId> units = plan.tree().units();
  const std::size_t trials = std::min(kTrials, units.size());
  const auto start = std::chrono::steady_clock::now();
  std::uint64_t bytes = 0;
  for (std::size_t t = 0; t < trials; ++t) {
    const std::vector<TileId> leaves = plan.tree().leaves(units[t * units.size() / trials]);
    const auto baked = bake_leaf(mosaic, plan, leaves[leaves.size() / 2], voids);
    if (!baked) return baked.error();
    bytes += encode_height_block(baked->tile, default_height_codec()).size();
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

}  // namespace cairn
