#include <algorithm>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <system_error>

#include <nlohmann/json.hpp>
#include <tbb/parallel_for.h>

#include "builder/bake/bake_target.h"
#include "builder/bake/memory_budget.h"
#include "builder/bake/output_check.h"
#include "builder/bake/thread_arena.h"
#include "builder/mosaic/mosaic_reach.h"
#include "builder/pack/bake_plan.h"
#include "builder/pack/make_pack.h"
#include "builder/pack/options_json.h"
#include "builder/pack/unit_keys.h"
#include "builder/shard/planned_bake.h"
#include "builder/shard/shard_tiles.h"
#include "cairn/bake_estimate.h"
#include "cairn/shards.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMostShards = 100'000;
constexpr std::int64_t kRowsAtOnce = 256;
constexpr std::int64_t kColumnsAtOnce = 4096;

/// Counts work that is done on several threads and tells of it on one.
class Steps {
 public:
  Steps(std::string stage, std::uint64_t total, const ProgressCallback& progress)
      : now_{std::move(stage), 0, total, 0}, progress_(progress) {}

  Status take() {
    const std::scoped_lock lock(mutex_);
    ++now_.done;
    return progress_(now_) ? Status() : cancelled(now_);
  }

 private:
  std::mutex mutex_;
  Progress now_;
  const ProgressCallback& progress_;
};

/// Calls work(i) for all i on all threads of the caller's arena; returns the first error by i.
template <class Work>
Status for_all(std::size_t count, const Work& work) {
  std::vector<Status> found(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) { found[i] = work(i); });
  const auto first = std::find_if(found.begin(), found.end(), [](const Status& s) { return !s.ok(); });
  return first == found.end() ? Status() : *first;
}

/// Reads every post, for the pool to know which sources have voids.
Status search_for_voids(RasterPool& pool, std::size_t source) {
  const RasterInfo& info = pool.info(source);
  std::vector<float> heights;
  for (std::int64_t row = 0; row < info.rows; row += kRowsAtOnce) {
    for (std::int64_t column = 0; column < info.columns; column += kColumnsAtOnce) {
      if (pool.has_voids(source)) return {};
      const PostWindow window{column, row, std::min(kColumnsAtOnce, info.columns - column),
                              std::min(kRowsAtOnce, info.rows - row)};
      heights.resize(static_cast<std::size_t>(window.columns * window.rows));
      if (auto status = pool.read_heights(source, window, heights); !status) return status;
    }
  }
  return {};
}

Status look_at_sources(const BakePlan& layers, const BuildOptions& options, const ProgressCallback& progress,
                       ShardPlan& plan) {
  const std::vector<fs::path> files = files_of(options);
  plan.files.resize(files.size());
  Steps hashed("plan: hashing", files.size(), progress);
  const Status looked = for_all(files.size(), [&](std::size_t f) -> Status {
    auto file = look_at(files[f]);
    if (!file) return file.error();
    plan.files[f] = std::move(*file);
    return hashed.take();
  });
  if (!looked || !layers.heights) return looked;
  RasterPool& pool = layers.heights->pool();
  Steps searched("plan: searching for voids", pool.size(), progress);
  const Status read = for_all(pool.size(), [&](std::size_t source) -> Status {
    if (auto status = search_for_voids(pool, source); !status) return status;
    return searched.take();
  });
  if (!read) return read;
  for (std::size_t s = 0; s < pool.size(); ++s) {
    plan.dems.push_back(pool.info(s));
    plan.has_voids.push_back(pool.has_voids(s) ? 1 : 0);
  }
  layers.heights->close_sources();
  return {};
}

/// The files that a shard reads.
std::vector<std::size_t> files_for(const BakePlan& layers, const BuildOptions& options,
                                   const MosaicReach* reach, const Shard& shard, bool with_geoid) {
  std::set<std::size_t> files;
  std::size_t dems = 0;
  if (layers.heights) {
    dems = layers.heights->pool().size();
    for (const TileId& unit : units_of(layers.plan->tree(), shard.heights)) {
      for (const auto& members : reach->near(without_overhang(tile_bounds(unit))))
        files.insert(members.sources.begin(), members.sources.end());
    }
  }
  std::size_t images = 0;
  if (layers.imagery) {
    images = layers.imagery->pool().size();
    for (const TileId& unit : units_of(*layers.imagery_tree, shard.imagery)) {
      const GeoBounds area = texture_area(unit, options.grid.tile_size - 1);
      for (const std::size_t source : layers.imagery->sources_near(area)) files.insert(dems + source);
    }
  }
  if (with_geoid && !shard.heights.subtrees.empty()) files.insert(dems + images);
  return {files.begin(), files.end()};
}

Status check_plan_target(const BuildOptions& options) {
  const fs::path& target = options.session.target;
  const auto inputs = files_of(options);
  if (auto status = check_is_no_input(target, inputs); !status) return status;
  if (auto status = check_can_be_file(target); !status) return status;
  std::error_code ignored;
  if (!fs::exists(target, ignored)) return {};
  if (!options.session.force) return usage_error(target.string() + std::string(kTargetExists));
  if (fs::file_size(target, ignored) == 0 || read_shard_plan(target).ok()) return {};
  return usage_error(target.string() + ": expected a plan to replace, found a file that is none");
}

Result<std::size_t> shard_count(const ShardSize& size, const DryRun& dry) {
  const std::uint64_t count = size.count ? *size.count
                                         : (dry.estimated_bytes + size.bytes.value_or(1) - 1) /
                                               std::max<std::uint64_t>(1, size.bytes.value_or(1));
  if (count > kMostShards)
    return usage_error("shards: expected at most " + std::to_string(kMostShards) + ", found " +
                       std::to_string(count));
  return static_cast<std::size_t>(std::max<std::uint64_t>(count, 1));
}

PlanReport report_of(const ShardPlan& plan) {
  PlanReport report;
  report.files = plan.files.size();
  report.memory_bytes = plan.memory_bytes;
  for (const Shard& shard : plan.shards) {
    PlanReport::Shard& row = report.shards.emplace_back();
    row.height_leaves = shard.heights.leaves;
    row.texture_leaves = shard.imagery.leaves;
    row.files = shard.files.size();
    for (const std::size_t file : shard.files) row.file_bytes += plan.files[file].bytes;
    row.estimated_bytes = shard.estimated_bytes;
    row.estimated_seconds = shard.estimated_seconds;
  }
  return report;
}

Result<PlanReport> plan_in_arena(const BuildOptions& options, const ShardSize& size, int threads,
                                 const ProgressCallback& progress) {
  if (auto status = check_plan_target(options); !status) return status.error();

  // 1. What the whole bake will be.
  const auto dry = dry_run(options);
  if (!dry) return dry.error();
  const auto count = shard_count(size, *dry);
  if (!count) return count.error();
  const auto layers = plan_bake(options, threads);
  if (!layers) return layers.error();

  // 2. What the sources are now.
  ShardPlan plan;
  plan.version = CAIRN_VERSION;
  plan.options = to_json(options);
  plan.allow_error = options.heights.allow_error;
  plan.with_geoid = options.mosaic.geoid.has_value();
  plan.places = options.objects.places.size();
  if (plan.places > 0) plan.models = options.objects.models;
  plan.memory_bytes = options.session.memory_bytes;
  if (auto status = look_at_sources(*layers, options, progress, plan); !status) return status.error();
  if (layers->imagery)
    for (std::size_t s = 0; s < layers->imagery->pool().size(); ++s)
      plan.images.push_back(layers->imagery->pool().info(s));

  // 3. Who makes which tiles, of which sources.
  const TileTree* height_tree = layers->heights ? &layers->plan->tree() : nullptr;
  const TileTree* image_tree = layers->imagery ? &*layers->imagery_tree : nullptr;
  DividedTiles tiles = divide_tiles(height_tree, image_tree, *count);
  plan.shards.resize(*count);
  std::uint64_t leaves = 0;
  for (std::size_t s = 0; s < *count; ++s) {
    plan.shards[s].heights = std::move(tiles.heights[s]);
    plan.shards[s].imagery = std::move(tiles.imagery[s]);
    leaves += plan.shards[s].heights.leaves + plan.shards[s].imagery.leaves;
  }
  std::optional<MosaicReach> reach;
  if (layers->heights) reach.emplace(*layers->heights);
  tbb::parallel_for(std::size_t{0}, *count, [&](std::size_t s) {
    Shard& shard = plan.shards[s];
    shard.files = files_for(*layers, options, reach ? &*reach : nullptr, shard, plan.with_geoid);
    const double share = static_cast<double>(shard.heights.leaves + shard.imagery.leaves) /
                         static_cast<double>(std::max<std::uint64_t>(leaves, 1));
    shard.estimated_bytes = static_cast<std::uint64_t>(share * static_cast<double>(dry->estimated_bytes));
    shard.estimated_seconds = share * dry->estimated_seconds;
  });

  if (auto status = write_shard_plan(plan, options.session.target); !status) return status.error();
  return report_of(plan);
}

}  // namespace

Result<PlanReport> plan_shards(const BuildOptions& options, const ShardSize& size,
                               const ProgressCallback& progress) {
  keep_freed_memory();
  return with_threads(options.session.threads,
                      [&](int threads) { return plan_in_arena(options, size, threads, progress); });
}

}  // namespace cairn
