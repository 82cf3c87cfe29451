#include "cairn/build.h"

#include <chrono>
#include <string_view>

#include "builder/bake/bake_session.h"
#include "builder/bake/bake_target.h"
#include "builder/bake/layer_bake.h"
#include "builder/bake/memory_budget.h"
#include "builder/bake/thread_arena.h"
#include "builder/pack/bake_plan.h"
#include "builder/pack/kept_units.h"
#include "builder/pack/make_pack.h"
#include "builder/raster/body_placement.h"

namespace cairn {
namespace {

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
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

  // 3. Make every tile from the sources; finish the pack.
  const auto bake = [&](auto& layer, const TileTree& tree, Progress& now) {
    return bake_layer(layer, tree, samples_per_leaf(options.grid.tile_size), threads, *session, now,
                      progress);
  };
  auto report = make_pack(
      *layers, options, threads, *session, {bake, bake}, [&hashing] { return hashing.hashes(); }, progress);
  if (!report) return end_failed_bake(*session, hashing, report.error());

  // 4. Keep what the units were made of, for an update.
  if (auto kept = keep_units(*session, *layers, options, *hashing.hashes()); !kept && report->warning.empty())
    report->warning = kept.error().message;
  report->resumed = session->resumed;
  report->threads = threads;
  report->seconds = seconds_since(start);
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
  if (is_error_of_bound(error)) remedies.push_back(Remedy::accept_error);
  const bool may_succeed = options.session.resume || error.code == ErrorCode::failed;
  if (may_succeed && Journal::fingerprint_of(options.session.target)) remedies.push_back(Remedy::resume);
  return remedies;
}

}  // namespace cairn
