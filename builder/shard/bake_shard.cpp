#include <algorithm>
#include <chrono>
#include <string>
#include <system_error>

#include "builder/bake/bake_session.h"
#include "builder/bake/bake_target.h"
#include "builder/bake/memory_budget.h"
#include "builder/bake/thread_arena.h"
#include "builder/pack/make_pack.h"
#include "builder/shard/part_sink.h"
#include "builder/shard/planned_bake.h"
#include "builder/shard/shard_tiles.h"
#include "cairn/shards.h"

namespace cairn {
namespace {

using Clock = std::chrono::steady_clock;

/// A shard's bake under way.
struct ShardBake {
  const BakePlan& layers;
  const BuildOptions& options;
  int threads;
  PartWriter& part;
  std::size_t next_done = 0;  ///< of the interrupted part's records
  const ProgressCallback& progress;
};

template <TileLayer L, class Make>
Status bake_tiles(ShardBake& bake, const char* stage, Layer kind, const Make& make, L& layer,
                  const TileTree& tree, const ShardTiles& tiles, std::uint64_t& samples) {
  const std::vector<TileId> units = units_of(tree, tiles);
  PartSink<L> sink(layer, kind, tree, tiles.subtrees, bake.part);
  const std::uint64_t per_leaf = samples_per_leaf(bake.options.grid.tile_size);
  Progress now{stage, 0, tiles.leaves * per_leaf, bake.part.bytes()};
  std::size_t done = 0;
  for (; done < units.size() && bake.next_done < bake.part.done(); ++done, ++bake.next_done) {
    const auto record = bake.part.read_done(bake.next_done);
    if (!record) return record.error();
    if (record->layer != kind || record->unit != units[done])
      return bad_data(bake.options.session.target.string() + ": record " + std::to_string(bake.next_done) +
                      ": expected " + to_string(units[done]) + ", found " + to_string(record->unit));
    now.done += tree.leaves(units[done]).size() * per_leaf;
    if (auto status = sink.replay(*record); !status) return status;
  }
  const auto written = [&] { return bake.part.bytes(); };
  const Status status =
      bake_units<L>(units, done, per_leaf, bake.threads, make, sink, written, now, bake.progress);
  samples = now.done;
  return status;
}

// The posts that are known to be measured finally are held against the error bound at once: a merge would
// find out late.
Status bake_heights(ShardBake& bake, const ShardTiles& tiles, std::uint64_t& samples) {
  const BakePlan& layers = bake.layers;
  const TileTree& tree = layers.plan->tree();
  HeightLayer heights(*layers.heights, *layers.plan, bake.options.heights.voids);
  const auto make = [&](const TileId& id) -> Result<UnitResult<HeightLayer>> {
    auto unit = bake_unit(heights, tree, id);
    if (!unit || bake.options.heights.allow_error) return unit;
    if (auto status = check_error_bound(unit->root->final_stats); !status) return status.error();
    return unit;
  };
  const Status status = bake_tiles(bake, "heights", Layer::heights, make, heights, tree, tiles, samples);
  layers.heights->close_sources();
  release_freed_memory();
  return status;
}

Status bake_imagery(ShardBake& bake, const ShardTiles& tiles, std::uint64_t& samples) {
  const TileTree& tree = *bake.layers.imagery_tree;
  ImageryLayer imagery(*bake.layers.imagery, bake.options.imagery, bake.options.grid.tile_size - 1);
  const auto make = [&](const TileId& id) { return bake_unit(imagery, tree, id); };
  return bake_tiles(bake, "imagery", Layer::imagery, make, imagery, tree, tiles, samples);
}

Status bake_layers(ShardBake& bake, const Shard& shard, ShardReport& report) {
  if (bake.layers.heights) {
    if (auto status = bake_heights(bake, shard.heights, report.samples); !status) return status;
  }
  return bake.layers.imagery ? bake_imagery(bake, shard.imagery, report.texels) : Status();
}

std::uint64_t count_units(const BakePlan& layers, const Shard& shard) {
  std::uint64_t units = 0;
  if (layers.heights) units += units_of(layers.plan->tree(), shard.heights).size();
  if (layers.imagery) units += units_of(*layers.imagery_tree, shard.imagery).size();
  return units;
}

Result<ShardReport> bake_in_arena(const std::filesystem::path& plan_file, std::size_t number,
                                  const SessionOptions& session, int threads,
                                  const ProgressCallback& progress) {
  const auto start = Clock::now();

  // 1. The plan, and the shard's files as they were planned.
  const auto plan = read_shard_plan(plan_file);
  if (!plan) return plan.error();
  if (number >= plan->shards.size())
    return usage_error(plan_file.string() + ": expected a shard below " +
                       std::to_string(plan->shards.size()) + ", found " + std::to_string(number));
  const Shard& shard = plan->shards[number];
  std::vector<std::filesystem::path> inputs{plan_file};
  for (const std::size_t file : shard.files) inputs.push_back(plan->files[file].path);
  if (auto status = check_part_target(session, inputs); !status) return status.error();
  if (auto status = check_files(*plan, shard); !status) return status.error();

  // 2. What the whole bake will be, as every shard works it out from the plan.
  auto options = options_of(*plan);
  if (!options) return options.error();
  const std::uint64_t memory = session.memory_bytes > 0 ? session.memory_bytes : plan->memory_bytes;
  options->session = session;
  options->session.memory_bytes = memory;
  const auto layers = plan_bake(sources_of(*plan, number), *options, threads);
  if (!layers) return layers.error();

  // 3. The shard's tiles, into a part.
  ShardReport report;
  report.units = count_units(*layers, shard);
  auto part =
      PartWriter::begin(session, {plan->version, shard.key, number, plan->shards.size(), report.units});
  if (!part) return part.error();
  report.resumed = part->done() > 0;
  ShardBake bake{*layers, *options, threads, *part, 0, progress};
  if (auto status = bake_layers(bake, shard, report); !status) {
    // Damaged input would end another try at the same place.
    if (!session.resume && status.error().code != ErrorCode::failed) remove_journal(session.target);
    return status.error();
  }
  if (auto status = part->finish(); !status) return status.error();

  std::error_code ignored;
  report.file_bytes = std::filesystem::file_size(session.target, ignored);
  report.threads = threads;
  report.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  return report;
}

}  // namespace

Result<ShardReport> bake_shard(const std::filesystem::path& plan, std::size_t shard,
                               const SessionOptions& session, const ProgressCallback& progress) {
  keep_freed_memory();
  return with_threads(session.threads,
                      [&](int threads) { return bake_in_arena(plan, shard, session, threads, progress); });
}

std::vector<Remedy> remedies_for_shard(const Error& error, const SessionOptions& session) {
  BuildOptions options;
  options.session = session;
  return remedies_for(error, options);
}

}  // namespace cairn
