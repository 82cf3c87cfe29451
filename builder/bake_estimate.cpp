#include "cairn/bake_estimate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "builder/bake/bake_target.h"
#include "builder/bake/layer_bake.h"
#include "builder/bake/thread_arena.h"
#include "builder/bake_plan.h"
#include "builder/heights/height_layer.h"
#include "builder/heights/rqt_layer.h"
#include "builder/imagery/imagery_layer.h"
#include "format/height_block.h"
#include "format/rqt_block.h"
#include "format/rqt_triangulate.h"

namespace cairn {
namespace {

constexpr double kIndexBytesPerTile = 18;  // of a page: a checksum, and what else is coded small

constexpr std::size_t kMostUnits = 8;    // that are baked on trial
constexpr std::size_t kMostLeaves = 48;  // in them

using Clock = std::chrono::steady_clock;

double elapsed_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What some units of a layer took, and what all of them will.
struct Trial {
  std::uint64_t leaves = 0;
  std::uint64_t tiles = 0;
  std::uint64_t bytes = 0;
  std::uint64_t root_bytes = 0;  ///< of the units' roots
  double seconds = 0;
  std::vector<TileBlock> blocks;
};

template <TileLayer L>
Result<Trial> try_units(const L& layer, const TileTree& tree) {
  Trial trial;
  const std::vector<TileId> units = tree.units();
  const std::size_t count = std::min(kMostUnits, units.size());
  for (std::size_t i = 0; i < count && trial.leaves < kMostLeaves; ++i) {
    const TileId& unit = units[(2 * i + 1) * units.size() / (2 * count)];
    const auto start = Clock::now();
    auto baked = bake_unit(layer, tree, unit);
    if (!baked) return baked.error();
    trial.seconds += elapsed_since(start);
    trial.leaves += baked->leaves;
    trial.tiles += baked->blocks.size();
    for (TileBlock& block : baked->blocks) {
      trial.bytes += block.block.size();
      if (block.entry.id == unit) trial.root_bytes += block.block.size();
      trial.blocks.push_back(std::move(block));
    }
  }
  return trial;
}

/// Adds the whole layer to `dry`, as a multiple of the trial. Each level above the units has about a fourth
/// of the bytes of the level below, since it has a fourth of the samples that are not void.
void add_whole(const Trial& trial, const TileTree& tree, int threads, DryRun& dry) {
  if (trial.leaves == 0) return;
  const double share = static_cast<double>(tree.leaf_count()) / static_cast<double>(trial.leaves);
  const double bytes = static_cast<double>(trial.bytes) + static_cast<double>(trial.root_bytes) / 3;
  const double entries = static_cast<double>(trial.tiles) * kIndexBytesPerTile;
  dry.estimated_bytes += static_cast<std::uint64_t>((bytes + entries) * share);
  dry.estimated_seconds += trial.seconds * share / threads;
}

/// Triangulates the trial's tiles of heights. Neighbours have to agree, which takes each tile twice.
Status add_rqt(const RqtPlan& plan, const Trial& heights, const TileTree& tree, int threads, DryRun& dry) {
  Trial trial;
  trial.leaves = heights.leaves;
  const auto start = Clock::now();
  for (const TileBlock& block : heights.blocks) {
    if (block.block.empty()) continue;
    const auto tile = decode_height_block(block.block, plan.tile_size);
    if (!tile) return tile.error();
    const TileId& id = block.entry.id;
    const float tolerance_m = std::ldexp(plan.tolerance_m, plan.finest - id.level);
    auto steps = triangulate(*tile, plan.quantum_m, tolerance_m, kRqtSteps, root_rises(id));
    trial.bytes += encode_rqt_block({tolerance_m, kRqtSteps, std::move(steps)}).size();
    ++trial.tiles;
  }
  trial.seconds = 2 * elapsed_since(start);
  add_whole(trial, tree, threads, dry);
  return {};
}

Status estimate_heights(const BakePlan& layers, const HeightOptions& options, int threads, DryRun& dry) {
  const HeightPlan& plan = *layers.plan;
  dry.top = plan.top();
  dry.finest = plan.finest();
  dry.error_bound_m = plan.error_bound_m();
  dry.quantum_m = plan.quantum_m();
  dry.tiles = plan.tree().tiles_by_level();
  const auto intervals = static_cast<std::uint64_t>(plan.tile_size() - 1);
  dry.samples = plan.tree().leaf_count() * intervals * intervals;
  const HeightLayer layer(*layers.heights, plan, options.voids);
  const auto trial = try_units(layer, plan.tree());
  if (!trial) return trial.error();
  add_whole(*trial, plan.tree(), threads, dry);
  if (!options.rqt_tolerance_m) return {};
  return add_rqt({plan.tile_size(), plan.quantum_m(), plan.finest(), *options.rqt_tolerance_m}, *trial,
                 plan.tree(), threads, dry);
}

Status estimate_imagery(const BakePlan& layers, const BuildOptions& options, int threads, DryRun& dry) {
  dry.texture_tiles = layers.imagery_tree->tiles_by_level();
  const ImageryLayer layer(*layers.imagery, options.imagery, options.grid.tile_size - 1);
  const auto trial = try_units(layer, *layers.imagery_tree);
  if (!trial) return trial.error();
  add_whole(*trial, *layers.imagery_tree, threads, dry);
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
    if (layers->heights) {
      if (auto status = estimate_heights(*layers, options.heights, threads, dry); !status)
        return status.error();
      layers->heights->close_sources();
    }
    if (layers->imagery) {
      if (auto status = estimate_imagery(*layers, options, threads, dry); !status) return status.error();
    }
    return dry;
  });
}

}  // namespace cairn
