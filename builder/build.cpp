#include "builder/build.h"

#include <chrono>
#include <system_error>

#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include "builder/build_metadata.h"
#include "builder/build_plan.h"
#include "builder/fingerprint.h"
#include "builder/height_layer.h"
#include "builder/layer_bake.h"
#include "builder/memory_budget.h"
#include "builder/mosaic.h"
#include "builder/resume.h"
#include "builder/trial.h"
#include "format/pack_writer.h"

namespace cairn {
namespace {

Status check_target(const BuildOptions& options) {
  std::error_code error;
  if (!options.force && std::filesystem::exists(options.target, error)) {
    return usage_error(options.target.string() + ": expected no such file, found one; --force replaces it");
  }
  return {};
}

PackHeader header_for(const BuildPlan& plan, const BuildOptions& options) {
  PackHeader header;
  header.tile_size = static_cast<std::uint16_t>(plan.tile_size());
  header.vertical_datum = options.geoid ? VerticalDatum::ellipsoid : options.datum;
  header.quantum_m = plan.quantum_m();
  return header;
}

Status check_promise(const PostStats& accuracy, const BuildPlan& plan) {
  if (accuracy.max() <= plan.promise_m()) return {};
  const LonLat at = accuracy.worst();
  return failed("accuracy: expected every post within " + std::to_string(plan.promise_m()) + " m, found " +
                std::to_string(accuracy.max()) + " m at lon " + std::to_string(at.lon) + " lat " +
                std::to_string(at.lat) + "; --allow-error bakes all the same");
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Result<BuildReport> build_in_arena(const BuildOptions& options, int threads,
                                   const ProgressCallback& progress) {
  const auto start = std::chrono::steady_clock::now();
  if (auto status = check_target(options); !status) return status.error();

  // 1. Ask every source what it is, and sort the sources into groups by their grids.
  const MemoryBudget memory = divide_memory(options.memory_bytes, threads, options.tile_size);
  auto mosaic = Mosaic::open(options, memory.cache_bytes);
  if (!mosaic) return mosaic.error();

  // 2. Choose levels, promise and quantum; lay out the tree of tiles.
  auto plan = BuildPlan::make(**mosaic, options);
  if (!plan) return plan.error();

  // 3. Go on from an interrupted bake of the same inputs and options, or start anew.
  const auto hashes = hash_inputs(options);
  if (!hashes) return hashes.error();
  auto work = begin_or_resume(options, header_for(*plan, options), *hashes);
  if (!work) return work.error();

  // 4. Sample, measure, encode and write every tile, the finest first, each above its children.
  HeightLayer heights(**mosaic, *plan, options.voids);
  const auto samples = bake_layer(heights, plan->tree(), threads, *work, progress);
  if (!samples) return discard(options, *work, samples.error());

  // 5. Hold the measured accuracy against the promise.
  const Status promise = check_promise(heights.summary().accuracy, *plan);
  if (!promise && !options.allow_error) return discard(options, *work, promise.error());

  // 6. Write metadata, index and header; the target appears.
  BuildReport report;
  report.metadata_json =
      describe_pack(**mosaic, *plan, options, heights.summary(), *hashes, work->writer.entries());
  if (auto status = work->writer.finish(report.metadata_json); !status)
    return discard(options, *work, status.error());
  remove_journal(options.target);

  report.promise_kept = promise.ok();
  if (!promise) report.warning = promise.error().message;
  report.samples = *samples;
  std::error_code ignored;
  report.file_bytes = std::filesystem::file_size(options.target, ignored);
  report.resumed = work->resumed;
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
  return with_threads(options.threads,
                      [&](int threads) { return build_in_arena(options, threads, progress); });
}

Result<DryRun> dry_run(const BuildOptions& options) {
  return with_threads(options.threads, [&](int threads) -> Result<DryRun> {
    const MemoryBudget memory = divide_memory(options.memory_bytes, threads, options.tile_size);
    auto mosaic = Mosaic::open(options, memory.cache_bytes);
    if (!mosaic) return mosaic.error();
    auto plan = BuildPlan::make(**mosaic, options);
    if (!plan) return plan.error();
    DryRun dry{plan->tile_size(),
               plan->top(),
               plan->finest(),
               plan->promise_m(),
               plan->quantum_m(),
               (*mosaic)->bounds(),
               plan->tree().tiles_by_level(),
               0,
               0,
               0,
               options.memory_bytes};
    if (auto status = estimate(**mosaic, *plan, options.voids, threads, dry); !status) return status.error();
    return dry;
  });
}

}  // namespace cairn
