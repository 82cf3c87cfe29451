#include "cairn/build.h"

#include <algorithm>
#include <chrono>
#include <string_view>
#include <system_error>

#include <nlohmann/json.hpp>

#include "builder/bake/bake_session.h"
#include "builder/bake/bake_target.h"
#include "builder/bake/layer_bake.h"
#include "builder/bake/memory_budget.h"
#include "builder/bake/thread_arena.h"
#include "builder/bake_plan.h"
#include "builder/heights/height_layer.h"
#include "builder/heights/rqt_layer.h"
#include "builder/imagery/imagery_layer.h"
#include "builder/options_json.h"
#include "builder/pack_metadata.h"
#include "builder/raster/body_placement.h"
#include "format/pack_writer.h"

namespace cairn {
namespace {

constexpr std::string_view kAccuracy = "accuracy: ";  // how the error of an exceeded bound begins

PackHeader header_for(const BakePlan& layers, const BuildOptions& options) {
  PackHeader header;
  header.tile_size = static_cast<std::uint16_t>(options.grid.tile_size);
  header.body = layers.body;
  if (layers.heights) {
    header.vertical_datum = layers.heights->datum().datum;
    header.other_datum = other_datum_of(layers.heights->datum());
  }
  if (layers.plan) header.quantum_m = layers.plan->quantum_m();
  return header;
}

Status check_error_bound(const ErrorStats& accuracy, const HeightPlan& plan) {
  if (accuracy.max() <= plan.error_bound_m()) return {};
  const LonLat at = accuracy.worst();
  return failed(std::string(kAccuracy) + "expected every post within " +
                std::to_string(plan.error_bound_m()) + " m, found " + std::to_string(accuracy.max()) +
                " m at lon " + std::to_string(at.lon) + " lat " + std::to_string(at.lat));
}

// A layer without a post or a pixel would be flat ground at 0 m, or nothing at all.
Status check_not_empty(const BakePlan& layers, const HeightSummary& heights,
                       const std::vector<PackLevel>& levels) {
  if (layers.heights && heights.accuracy.count() == 0)
    return bad_data(layers.heights->pool().info(0).path.string() +
                    ": heights: expected a post with a value in the DEMs, found voids alone");
  const bool textured = std::any_of(levels.begin(), levels.end(),
                                    [](const PackLevel& level) { return level.layer == Layer::imagery; });
  if (layers.imagery && !textured)
    return bad_data(layers.imagery->pool().info(0).path.string() +
                    ": image: expected a pixel that is not transparent in the images, found none");
  return {};
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

BakeIdentity identity_of(const BuildOptions& options) {
  return {files_of(options), std::string(CAIRN_VERSION) + " " + std::to_string(options.mosaic.inputs.size()) +
                                 " DEMs " + std::to_string(options.imagery.inputs.size()) + " images " +
                                 to_json(options).dump()};
}

// A layer's progress from its start. All its leaves have as many samples as a tile has cells.
struct LayerProgress {
  std::uint64_t samples_per_leaf;
  Progress now;

  LayerProgress(const char* stage, const TileTree& tree, int tile_size)
      : samples_per_leaf(static_cast<std::uint64_t>(tile_size - 1) *
                         static_cast<std::uint64_t>(tile_size - 1)),
        now{stage, 0, tree.leaf_count() * samples_per_leaf, 0} {}
};

Result<HeightSummary> bake_heights(const BakePlan& layers, const BuildOptions& options, int threads,
                                   BakeSession& session, const ProgressCallback& progress,
                                   BuildReport& report) {
  if (!layers.heights) return HeightSummary{};
  HeightLayer heights(*layers.heights, *layers.plan, options.heights.voids);
  const TileTree& tree = layers.plan->tree();
  LayerProgress done("heights", tree, options.grid.tile_size);
  if (auto status = bake_layer(heights, tree, done.samples_per_leaf, threads, session, done.now, progress);
      !status)
    return status.error();
  report.samples = done.now.done;
  layers.heights->close_sources();
  release_freed_memory();
  return heights.summary();
}

Status bake_imagery(const BakePlan& layers, const BuildOptions& options, int threads, BakeSession& session,
                    const ProgressCallback& progress, BuildReport& report) {
  if (!layers.imagery) return {};
  ImageryLayer imagery(*layers.imagery, options.imagery, options.grid.tile_size - 1);
  const TileTree& tree = *layers.imagery_tree;
  LayerProgress done("imagery", tree, options.grid.tile_size);
  const auto status = bake_layer(imagery, tree, done.samples_per_leaf, threads, session, done.now, progress);
  report.texels = done.now.done;
  return status;
}

Status bake_rqt(const BakePlan& layers, const BuildOptions& options, int threads, BakeSession& session,
                const ProgressCallback& progress) {
  if (!layers.plan || !options.heights.rqt_tolerance_m) return {};
  const RqtPlan plan{options.grid.tile_size, layers.plan->quantum_m(), layers.plan->finest(),
                     *options.heights.rqt_tolerance_m};
  return bake_rqt_layers(plan, threads, session, progress);
}

Result<BuildReport> build_in_arena(const BuildOptions& options, int threads,
                                   const ProgressCallback& progress) {
  const auto start = std::chrono::steady_clock::now();
  const BakeIdentity identity = identity_of(options);
  if (auto status = check_target(options.session, identity.inputs); !status) return status.error();

  // 1. Ask every source what it is. Choose levels, error bound and quantum; lay out the trees of tiles.
  auto layers = plan_bake(options, threads);
  if (!layers) return layers.error();

  // 2. Go on from an interrupted bake of the same inputs and options, or start anew.
  auto session = begin_session(options.session, identity, header_for(*layers, options));
  if (!session) return session.error();
  InputHashing hashing(*session);

  // 3. Sample, measure, encode and write every tile of heights, the finest first, each above its children.
  BuildReport report;
  auto heights = bake_heights(*layers, options, threads, *session, progress, report);
  if (!heights) return end_failed_bake(*session, hashing, heights.error());

  // 4. Hold the measured accuracy against the error bound.
  const Status bounded = layers->plan ? check_error_bound(heights->accuracy, *layers->plan) : Status();
  if (!bounded && !options.heights.allow_error) return end_failed_bake(*session, hashing, bounded.error());

  // 5. The same for the tiles of imagery: resample, encode, measure, write.
  if (auto status = bake_imagery(*layers, options, threads, *session, progress, report); !status)
    return end_failed_bake(*session, hashing, status.error());

  if (auto status = check_not_empty(*layers, *heights, session->writer.levels()); !status)
    return end_failed_bake(*session, hashing, status.error());

  // 6. Triangulate the tiles of heights, if asked for: neighbours have to agree, so they are all needed
  // first.
  if (auto status = bake_rqt(*layers, options, threads, *session, progress); !status)
    return end_failed_bake(*session, hashing, status.error());

  // 7. Write metadata, index and header; the target appears.
  const auto hashes = hashing.hashes();
  if (!hashes) return end_failed_bake(*session, hashing, hashes.error());
  auto metadata = describe_pack(*layers, options, *heights, *hashes, session->writer);
  if (!metadata) return end_failed_bake(*session, hashing, metadata.error());
  report.metadata_json = std::move(*metadata);
  if (auto status = session->writer.finish(report.metadata_json); !status)
    return end_failed_bake(*session, hashing, status.error());
  remove_journal(options.session.target);

  report.within_error_bound = bounded.ok();
  if (!bounded) report.warning = bounded.error().message;
  std::error_code ignored;
  report.file_bytes = std::filesystem::file_size(options.session.target, ignored);
  report.resumed = session->resumed;
  report.threads = threads;
  report.seconds = seconds_since(start);
  return report;
}

}  // namespace

Result<BuildReport> build(const BuildOptions& options, const ProgressCallback& progress) {
  keep_freed_memory();
  return with_threads(options.session.threads,
                      [&](int threads) { return build_in_arena(options, threads, progress); });
}

std::vector<Remedy> remedies_for(const Error& error, const BuildOptions& options) {
  const std::string_view message = error.message;
  if (error.code == ErrorCode::usage) {
    if (message.ends_with(kTargetExists)) return {Remedy::replace_target};
    if (message.ends_with(kWorkExists)) return {Remedy::resume, Remedy::discard_work};
    if (message.ends_with(kOtherWork)) return {Remedy::discard_work};
    return {};
  }
  std::vector<Remedy> remedies;
  if (message.ends_with(kBodyUnsettled)) remedies.push_back(Remedy::tell_body);
  if (message.ends_with(kLatitudeUnsettled)) remedies.push_back(Remedy::tell_latitude);
  if (message.starts_with(kAccuracy)) remedies.push_back(Remedy::accept_error);
  const bool may_succeed = options.session.resume || error.code == ErrorCode::failed;
  if (may_succeed && Journal::fingerprint_of(options.session.target)) remedies.push_back(Remedy::resume);
  return remedies;
}

}  // namespace cairn
