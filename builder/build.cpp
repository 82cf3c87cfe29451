#include "cairn/build.h"

#include <chrono>
#include <system_error>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "builder/bake/bake_session.h"
#include "builder/bake/bake_target.h"
#include "builder/bake/fingerprint.h"
#include "builder/bake/layer_bake.h"
#include "builder/bake/memory_budget.h"
#include "builder/bake_estimate.h"
#include "builder/bake_plan.h"
#include "builder/heights/height_layer.h"
#include "builder/heights/rqt_layer.h"
#include "builder/imagery/imagery_layer.h"
#include "builder/pack_metadata.h"
#include "format/pack_writer.h"

namespace cairn {
namespace {

PackHeader header_for(const BakePlan& layers, const BuildOptions& options) {
  PackHeader header;
  header.tile_size = static_cast<std::uint16_t>(options.tile_size);
  header.vertical_datum = options.geoid ? VerticalDatum::ellipsoid : options.datum;
  if (layers.plan) header.quantum_m = layers.plan->quantum_m();
  return header;
}

Status check_error_bound(const ErrorStats& accuracy, const HeightPlan& plan) {
  if (accuracy.max() <= plan.error_bound_m()) return {};
  const LonLat at = accuracy.worst();
  return failed("accuracy: expected every post within " + std::to_string(plan.error_bound_m()) +
                " m, found " + std::to_string(accuracy.max()) + " m at lon " + std::to_string(at.lon) +
                " lat " + std::to_string(at.lat) + "; --allow-error bakes all the same");
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Result<HeightSummary> bake_heights(const BakePlan& layers, const BuildOptions& options, int threads,
                                   BakeSession& session, const ProgressCallback& progress,
                                   BuildReport& report) {
  if (!layers.heights) return HeightSummary{};
  HeightLayer heights(*layers.heights, *layers.plan, options.voids);
  const auto samples = bake_layer(heights, layers.plan->tree(), threads, session, progress);
  if (!samples) return samples.error();
  report.samples = *samples;
  layers.heights->close_sources();
  release_freed_memory();
  return heights.summary();
}

Status bake_imagery(const BakePlan& layers, const BuildOptions& options, int threads, BakeSession& session,
                    const ProgressCallback& progress, BuildReport& report) {
  if (!layers.imagery) return {};
  ImageryLayer imagery(*layers.imagery, options.imagery, options.tile_size - 1);
  const auto texels = bake_layer(imagery, *layers.imagery_tree, threads, session, progress);
  if (!texels) return texels.error();
  report.texels = *texels;
  return {};
}

Status bake_rqt(const BakePlan& layers, const BuildOptions& options, int threads, BakeSession& session,
                const ProgressCallback& progress) {
  if (!layers.plan || !options.rqt_tolerance_m) return {};
  const RqtPlan plan{options.tile_size, layers.plan->quantum_m(), layers.plan->finest(),
                     *options.rqt_tolerance_m};
  return bake_rqt_layer(plan, options.target, threads, session, progress);
}

Result<BuildReport> build_in_arena(const BuildOptions& options, int threads,
                                   const ProgressCallback& progress) {
  const auto start = std::chrono::steady_clock::now();
  if (auto status = check_target(options); !status) return status.error();

  // 1. Ask every source what it is. Choose levels, error bound and quantum; lay out the trees of tiles.
  auto layers = plan_bake(options, threads);
  if (!layers) return layers.error();

  // 2. Go on from an interrupted bake of the same inputs and options, or start anew.
  auto session = begin_session(options, header_for(*layers, options));
  if (!session) return session.error();
  InputHashing hashing(options, *session);

  // 3. Sample, measure, encode and write every tile of heights, the finest first, each above its children.
  BuildReport report;
  auto heights = bake_heights(*layers, options, threads, *session, progress, report);
  if (!heights) return discard(options, *session, heights.error());

  // 4. Hold the measured accuracy against the error bound.
  const Status bounded = layers->plan ? check_error_bound(heights->accuracy, *layers->plan) : Status();
  if (!bounded && !options.allow_error) return discard(options, *session, bounded.error());

  // 5. The same for the tiles of imagery: resample, encode, measure, write.
  if (auto status = bake_imagery(*layers, options, threads, *session, progress, report); !status)
    return discard(options, *session, status.error());

  // 6. Triangulate the tiles of heights, if asked for: neighbours have to agree, so they are all needed
  // first.
  if (auto status = bake_rqt(*layers, options, threads, *session, progress); !status)
    return discard(options, *session, status.error());

  // 7. Write metadata, index and header; the target appears.
  const auto hashes = hashing.hashes();
  if (!hashes) return discard(options, *session, hashes.error());
  report.metadata_json = describe_pack(*layers, options, *heights, *hashes, session->writer.entries());
  if (auto status = session->writer.finish(report.metadata_json); !status)
    return discard(options, *session, status.error());
  remove_journal(options.target);

  report.within_error_bound = bounded.ok();
  if (!bounded) report.warning = bounded.error().message;
  std::error_code ignored;
  report.file_bytes = std::filesystem::file_size(options.target, ignored);
  report.resumed = session->resumed;
  report.threads = threads;
  report.seconds = seconds_since(start);
  return report;
}

// Runs `work` with this many threads, the calling one included.
template <class Work>
auto with_threads(int asked, const Work& work) {
  const int threads = asked > 0 ? asked : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  return arena.execute([&] { return work(threads); });
}

}  // namespace

Result<BuildReport> build(const BuildOptions& options, const ProgressCallback& progress) {
  keep_freed_memory();
  return with_threads(options.threads,
                      [&](int threads) { return build_in_arena(options, threads, progress); });
}

Result<DryRun> dry_run(const BuildOptions& options) {
  return with_threads(options.threads, [&](int threads) -> Result<DryRun> {
    if (auto status = check_target_is_no_input(options); !status) return status.error();
    const auto layers = plan_bake(options, threads);
    if (!layers) return layers.error();
    DryRun dry;
    dry.tile_size = options.tile_size;
    dry.bounds = layers->bounds();
    dry.memory_bytes = options.memory_bytes;
    if (layers->imagery) dry.texture_tiles = layers->imagery_tree->tiles_by_level();
    if (!layers->heights) return dry;
    const HeightPlan& plan = *layers->plan;
    dry.top = plan.top();
    dry.finest = plan.finest();
    dry.error_bound_m = plan.error_bound_m();
    dry.quantum_m = plan.quantum_m();
    dry.tiles = plan.tree().tiles_by_level();
    if (auto status = estimate(*layers->heights, plan, options.voids, threads, dry); !status)
      return status.error();
    return dry;
  });
}

}  // namespace cairn
