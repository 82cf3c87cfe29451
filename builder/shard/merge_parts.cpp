#include <algorithm>
#include <chrono>
#include <optional>
#include <string>

#include <malloc.h>

#include "builder/bake/bake_target.h"
#include "builder/bake/layer_bake.h"
#include "builder/bake/memory_budget.h"
#include "builder/bake/thread_arena.h"
#include "builder/pack/kept_units.h"
#include "builder/pack/make_pack.h"
#include "builder/shard/part_merge.h"
#include "builder/shard/planned_bake.h"
#include "builder/shard/shard_tiles.h"
#include "cairn/shards.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr int kLargestRecord = 16 << 20;  // bytes of a part's record, whose memory the next one takes over

/// The part of each shard, by number.
struct Parts {
  std::vector<MergedPart> by_shard;
};

Result<Parts> find_parts(const fs::path& plan_file, const ShardPlan& plan,
                         const std::vector<fs::path>& files) {
  Parts parts;
  parts.by_shard.resize(plan.shards.size());
  for (const fs::path& file : files) {
    const auto part = PartReader::open(file);
    if (!part) return part.error();
    const PartDescription& d = part->description();
    if (d.version != plan.version)
      return bad_data(file.string() + ": expected a part that cairn " + plan.version +
                      " made, found one of cairn " + d.version);
    if (d.shards != plan.shards.size() || d.shard >= plan.shards.size())
      return bad_data(file.string() + ": expected a part of " + std::to_string(plan.shards.size()) +
                      " shards, as in " + plan_file.string() + ", found shard " + std::to_string(d.shard) +
                      " of " + std::to_string(d.shards));
    if (d.key != plan.shards[d.shard].key)
      return bad_data(file.string() + ": expected shard " + std::to_string(d.shard) + " of " +
                      plan_file.string() + " with the key " + hex_of(plan.shards[d.shard].key) +
                      ", found one of other inputs or options with the key " + hex_of(d.key));
    MergedPart& own = parts.by_shard[d.shard];
    if (!own.path.empty())
      return usage_error(file.string() + ": expected each shard once, found shard " +
                         std::to_string(d.shard) + " in " + own.path.string() + " too");
    own = {file, part->position()};
  }
  for (std::size_t s = 0; s < parts.by_shard.size(); ++s) {
    if (parts.by_shard[s].path.empty())
      return usage_error(plan_file.string() + ": expected a part for each of " +
                         std::to_string(plan.shards.size()) + " shards, found none for shard " +
                         std::to_string(s));
  }
  return parts;
}

/// The end of every part is where its last unit is.
Status check_ends(const Parts& parts) {
  for (const MergedPart& part : parts.by_shard) {
    auto reader = PartReader::open_at(part.path, part.position);
    if (!reader) return reader.error();
    if (auto status = reader->check_end(); !status) return status;
  }
  return {};
}

Result<BuildReport> merge_in_arena(const fs::path& plan_file, const std::vector<fs::path>& files,
                                   const SessionOptions& asked, int threads,
                                   const ProgressCallback& progress) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<fs::path> inputs = files;
  inputs.push_back(plan_file);
  if (auto status = check_target(asked, inputs); !status) return status.error();

  // 1. The plan, and a part of every shard.
  const auto plan = read_shard_plan(plan_file);
  if (!plan) return plan.error();
  auto parts = find_parts(plan_file, *plan, files);
  if (!parts) return parts.error();

  // 2. What the whole bake is, from the plan alone.
  auto options = options_of(*plan);
  if (!options) return options.error();
  if (auto status = check_object_files(*plan, *options); !status) return status.error();
  options->session = asked;
  options->session.resume = false;
  const auto layers = plan_bake(sources_of(*plan, std::nullopt), *options, threads);
  if (!layers) return layers.error();
  auto session = begin_session(options->session, identity_of(*options), header_for(*layers, *options));
  if (!session) return session.error();

  // 3. The units in the order of the trees' walks; the tiles above the shards' subtrees; the pack.
  const std::uint64_t per_leaf = samples_per_leaf(options->grid.tile_size);
  const auto merge = [&](auto& layer, const TileTree& tree, Progress& now, Layer kind,
                         ShardTiles Shard::*tiles) -> Status {
    LayerSink sink(layer, tree, *session);
    now.stage = std::string("merge: ") + to_string(kind);
    for (std::size_t s = 0; s < plan->shards.size(); ++s) {
      const Status status = merge_part(parts->by_shard[s], units_of(tree, plan->shards[s].*tiles), kind,
                                       layer, tree, per_leaf, *session, sink, now, progress);
      if (!status) return status;
    }
    return {};
  };
  const LayerMakers makers{[&](HeightLayer& layer, const TileTree& tree, Progress& now) {
                             return merge(layer, tree, now, Layer::heights, &Shard::heights);
                           },
                           [&](ImageryLayer& layer, const TileTree& tree, Progress& now) {
                             return merge(layer, tree, now, Layer::imagery, &Shard::imagery);
                           }};
  const auto hashes = [&]() -> Result<std::vector<std::uint64_t>> {
    if (auto status = check_ends(*parts); !status) return status.error();
    std::vector<std::uint64_t> all;
    for (const PlannedFile& file : plan->files) all.push_back(file.hash);
    return all;
  };
  auto report = make_pack(*layers, *options, threads, *session, makers, hashes, progress);
  if (!report) {
    session->writer.abandon();
    remove_journal(asked.target);
    return report.error();
  }
  if (layers->heights) {
    for (std::size_t dem = 0; dem < plan->dems.size(); ++dem)
      if (plan->has_voids[dem] != 0) layers->heights->pool().expect_voids(dem);
  }
  if (auto named = session->journal.identify(plan->id); !named) return named.error();
  if (auto kept = keep_units(*session, *layers, *options, *hashes()); !kept && report->warning.empty())
    report->warning = kept.error().message;
  report->threads = threads;
  report->seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace

Result<BuildReport> merge_parts(const fs::path& plan, const std::vector<fs::path>& parts,
                                const SessionOptions& session, const ProgressCallback& progress) {
  keep_freed_memory();
  ::mallopt(M_MMAP_THRESHOLD, kLargestRecord);
  return with_threads(session.threads,
                      [&](int threads) { return merge_in_arena(plan, parts, session, threads, progress); });
}

}  // namespace cairn
