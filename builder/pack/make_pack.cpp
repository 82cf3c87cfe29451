#include "builder/pack/make_pack.h"

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include <nlohmann/json.hpp>

#include "builder/bake/memory_budget.h"
#include "builder/heights/rqt_layer.h"
#include "builder/objects/object_layer.h"
#include "builder/pack/options_json.h"
#include "builder/pack/pack_metadata.h"
#include "format/pack_writer.h"

namespace cairn {
namespace {

constexpr std::string_view kAccuracy = "accuracy: ";  // how the error of an exceeded bound begins

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

// A layer's progress from its start. All its leaves have as many samples as a tile has cells.
Progress progress_over(const char* stage, const TileTree& tree, int tile_size) {
  return {stage, 0, tree.leaf_count() * samples_per_leaf(tile_size), 0};
}

Result<HeightSummary> make_heights(const BakePlan& layers, const BuildOptions& options,
                                   const MakeLayer<HeightLayer>& make, BuildReport& report) {
  if (!layers.heights) return HeightSummary{};
  HeightLayer heights(*layers.heights, *layers.plan, options.heights.voids);
  const TileTree& tree = layers.plan->tree();
  Progress now = progress_over("heights", tree, options.grid.tile_size);
  if (auto status = make(heights, tree, now); !status) return status.error();
  report.samples = now.done;
  layers.heights->close_sources();
  release_freed_memory();
  return heights.summary();
}

Status make_imagery(const BakePlan& layers, const BuildOptions& options, const MakeLayer<ImageryLayer>& make,
                    BuildReport& report) {
  if (!layers.imagery) return {};
  ImageryLayer imagery(*layers.imagery, options.imagery, options.grid.tile_size - 1);
  const TileTree& tree = *layers.imagery_tree;
  Progress now = progress_over("imagery", tree, options.grid.tile_size);
  const auto status = make(imagery, tree, now);
  report.texels = now.done;
  return status;
}

Status make_rqt(const BakePlan& layers, const BuildOptions& options, int threads, BakeSession& session,
                const ProgressCallback& progress) {
  if (!layers.plan || !options.heights.rqt_tolerance_m) return {};
  const RqtPlan plan{options.grid.tile_size, layers.plan->quantum_m(), layers.plan->finest(),
                     *options.heights.rqt_tolerance_m};
  return bake_rqt_layers(plan, threads, session, progress);
}

Result<std::optional<ObjectSummary>> make_objects(const BakePlan& layers, const BuildOptions& options,
                                                  int threads, BakeSession& session,
                                                  const ProgressCallback& progress, BuildReport& report) {
  using Made = std::optional<ObjectSummary>;
  if (options.objects.places.empty()) return Made();
  const ObjectGround ground{layers.body, options.grid.tile_size, layers.plan->quantum_m(),
                            cut_to(options.grid.region, layers.heights->bounds())};
  auto made = bake_objects(options.objects, ground, threads, session, progress);
  if (!made) return made.error();
  if (made->left_out != 0)
    report.warning = "objects: " + std::to_string(made->left_out) + " of " +
                     std::to_string(made->objects + made->left_out) +
                     " left out, as there is no ground beneath them, the first at lon " +
                     std::to_string(made->first_left_out.lon) + " lat " +
                     std::to_string(made->first_left_out.lat);
  return Made(std::move(*made));
}

}  // namespace

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

BakeIdentity identity_of(const BuildOptions& options) {
  return {files_of(options), std::string(CAIRN_VERSION) + " " + std::to_string(options.mosaic.inputs.size()) +
                                 " DEMs " + std::to_string(options.imagery.inputs.size()) + " images " +
                                 to_json(options).dump()};
}

std::uint64_t samples_per_leaf(int tile_size) {
  return static_cast<std::uint64_t>(tile_size - 1) * static_cast<std::uint64_t>(tile_size - 1);
}

bool is_error_of_bound(const Error& error) {
  return std::string_view(error.message).starts_with(kAccuracy);
}

Status check_error_bound(const ErrorStats& accuracy) {
  const auto& excess = accuracy.excess();
  if (!excess) return {};
  return failed(std::string(kAccuracy) + "expected every post within " + std::to_string(excess->bound_m) +
                " m, found " + std::to_string(excess->error_m) + " m at lon " +
                std::to_string(excess->place.lon) + " lat " + std::to_string(excess->place.lat));
}

Result<BuildReport> make_pack(const BakePlan& layers, const BuildOptions& options, int threads,
                              BakeSession& session, const LayerMakers& makers,
                              const std::function<Result<std::vector<std::uint64_t>>()>& hashes,
                              const ProgressCallback& progress) {
  // 1. Sample, measure, encode and write every tile of heights, the finest first, each above its children.
  BuildReport report;
  const auto heights = make_heights(layers, options, makers.heights, report);
  if (!heights) return heights.error();

  // 2. Hold the measured accuracy against the error bound.
  const Status bounded = check_error_bound(heights->accuracy);
  if (!bounded && !options.heights.allow_error) return bounded.error();

  // 3. The same for the tiles of imagery: resample, encode, measure, write.
  if (auto status = make_imagery(layers, options, makers.imagery, report); !status) return status.error();
  if (auto status = check_not_empty(layers, *heights, session.writer.levels()); !status)
    return status.error();

  // 4. Triangulate the tiles of heights, if asked for: neighbours have to agree, so they are all needed
  // first.
  if (auto status = make_rqt(layers, options, threads, session, progress); !status) return status.error();

  // 5. Place objects on the ground, which is all there now.
  const auto objects = make_objects(layers, options, threads, session, progress, report);
  if (!objects) return objects.error();

  // 6. Write metadata, index and header; the target appears.
  const auto input_hashes = hashes();
  if (!input_hashes) return input_hashes.error();
  auto metadata = describe_pack(layers, options, *heights, *objects, *input_hashes, session.writer);
  if (!metadata) return metadata.error();
  report.metadata_json = std::move(*metadata);
  if (auto status = session.writer.finish(report.metadata_json); !status) return status.error();

  report.within_error_bound = bounded.ok();
  if (!bounded)
    report.warning = bounded.error().message + (report.warning.empty() ? "" : "; ") + report.warning;
  std::error_code ignored;
  report.file_bytes = std::filesystem::file_size(options.session.target, ignored);
  return report;
}

}  // namespace cairn
