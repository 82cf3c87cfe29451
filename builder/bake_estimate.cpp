#include "cairn/bake_estimate.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "builder/bake/bake_target.h"
#include "builder/bake/layer_bake.h"
#include "builder/bake/thread_arena.h"
#include "builder/heights/height_layer.h"
#include "builder/heights/rqt_layer.h"
#include "builder/imagery/imagery_layer.h"
#include "builder/pack/bake_plan.h"
#include "format/height_block.h"
#include "format/rqt_block.h"
#include "format/rqt_triangulate.h"

namespace cairn {
namespace {

constexpr double kIndexBytesPerTile = 18;      // of a page: a checksum, and what else is coded small
constexpr std::size_t kPieces = 12;            // subtrees of at most four leaves, that are baked on trial …
constexpr std::uint64_t kFewLeaves = 96;       // … unless there are so few leaves that all are
constexpr std::uint64_t kBytesOfSource = 280;  // in the metadata

using Clock = std::chrono::steady_clock;

double elapsed_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// What some subtrees of a layer took.
struct Trial {
  std::uint64_t leaves = 0;
  std::uint64_t tiles = 0;
  std::uint64_t bytes = 0;
  std::uint64_t root_bytes = 0;  ///< of the subtrees' roots, where there are more tiles above them
  double seconds = 0;
  double seconds_of_first = 0;
  std::uint64_t leaves_of_first = 0;
  std::vector<TileBlock> blocks;

  void add(TileBlock&& block) {
    bytes += block.block.size();
    ++tiles;
    blocks.push_back(std::move(block));
  }
};

template <TileLayer L>
Result<UnitResult<L>> try_subtree(const L& layer, const TileTree& tree, const TileId& root, Trial& trial) {
  const auto start = Clock::now();
  auto baked = bake_unit(layer, tree, root);
  if (!baked) return baked;
  trial.seconds += elapsed_since(start);
  if (trial.leaves == 0) {
    trial.seconds_of_first = trial.seconds;
    trial.leaves_of_first = baked->leaves;
  }
  trial.leaves += baked->leaves;
  for (TileBlock& block : baked->blocks) trial.add(std::move(block));
  if (baked->root_block) {
    trial.root_bytes += baked->root_block->block.size();
    trial.add(std::move(*baked->root_block));
  }
  return baked;
}

/// The whole layer, the tiles above the units too.
template <TileLayer L>
Result<Trial> try_all(const L& layer, const TileTree& tree) {
  Trial trial;
  Pyramid<L> above(layer, tree);
  for (const TileId& unit : tree.units()) {
    auto baked = try_subtree(layer, tree, unit, trial);
    if (!baked) return baked.error();
    std::optional<typename L::Node> node = std::move(baked->root);
    while (node && node->id.level > tree.top()) {
      auto finished = above.merge(*node, std::nullopt);  // what is stored of it is counted
      node.reset();
      if (!finished) break;
      node = std::move(finished->parent);
      if (auto block = prune_or_encode(layer, *node)) trial.add(std::move(*block));
    }
  }
  trial.root_bytes = 0;
  return trial;
}

/// The unit itself where it is a leaf, else one of its children that holds leaves: the k-th of the four, or
/// the next.
TileId piece_of(const TileTree& tree, const TileId& unit, std::size_t k) {
  if (tree.is_leaf(unit)) return unit;
  for (std::size_t q = 0; q < 4; ++q) {
    const TileId child = child_of(unit, static_cast<int>((k + q) % 4));
    if (!tree.leaves(child).empty()) return child;
  }
  return unit;
}

/// Subtrees that lie evenly among the units.
template <TileLayer L>
Result<Trial> try_pieces(const L& layer, const TileTree& tree) {
  Trial trial;
  const std::vector<TileId> units = tree.units();
  const std::size_t count = std::min(kPieces, units.size());
  for (std::size_t i = 0; i < count; ++i) {
    const TileId& unit = units[(2 * i + 1) * units.size() / (2 * count)];
    if (const auto baked = try_subtree(layer, tree, piece_of(tree, unit, i), trial); !baked)
      return baked.error();
  }
  return trial;
}

template <TileLayer L>
Result<Trial> try_layer(const L& layer, const TileTree& tree) {
  return tree.leaf_count() <= kFewLeaves ? try_all(layer, tree) : try_pieces(layer, tree);
}

/// Adds the whole layer to `dry`, as a multiple of the trial. Each level above the subtrees has about a
/// fourth of the bytes of the level below, since it has a fourth of the samples that are not void. The first
/// subtree of many is no measure of time: files are opened and libraries loaded in it.
void add_whole(const Trial& trial, const TileTree& tree, int threads, DryRun& dry) {
  if (trial.leaves == 0) return;
  const auto all = static_cast<double>(tree.leaf_count());
  const double share = all / static_cast<double>(trial.leaves);
  const double bytes = static_cast<double>(trial.bytes) + static_cast<double>(trial.root_bytes) / 3;
  const double entries = static_cast<double>(trial.tiles) * kIndexBytesPerTile;
  dry.estimated_bytes += static_cast<std::uint64_t>((bytes + entries) * share);
  const std::uint64_t later = trial.leaves - trial.leaves_of_first;
  const double seconds_per_leaf = later >= kPieces
                                      ? (trial.seconds - trial.seconds_of_first) / static_cast<double>(later)
                                      : trial.seconds / static_cast<double>(trial.leaves);
  dry.estimated_seconds += seconds_per_leaf * all / threads;
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
  const auto trial = try_layer(layer, plan.tree());
  if (!trial) return trial.error();
  add_whole(*trial, plan.tree(), threads, dry);
  if (!options.rqt_tolerance_m) return {};
  return add_rqt({plan.tile_size(), plan.quantum_m(), plan.finest(), *options.rqt_tolerance_m}, *trial,
                 plan.tree(), threads, dry);
}

Status estimate_imagery(const BakePlan& layers, const BuildOptions& options, int threads, DryRun& dry) {
  dry.texture_tiles = layers.imagery_tree->tiles_by_level();
  const ImageryLayer layer(*layers.imagery, options.imagery, options.grid.tile_size - 1);
  const auto trial = try_layer(layer, *layers.imagery_tree);
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
    dry.estimated_bytes += kBytesOfSource * (options.mosaic.inputs.size() + options.imagery.inputs.size());
    return dry;
  });
}

}  // namespace cairn
