#include "builder/pack/pack_metadata.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/heights/rqt_layer.h"
#include "builder/imagery/texture_tile_encode.h"
#include "builder/pack/options_json.h"
#include "builder/raster/footprint.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const GeoBounds& b) {
  return {{"west", b.west}, {"south", b.south}, {"east", b.east}, {"north", b.north}};
}

Json json_of(const ErrorStats& s) {
  Json json{{"posts", s.count()},
            {"max_m", s.max()},
            {"rms_m", s.rms()},
            {"p50_m", s.percentile(0.50)},
            {"p95_m", s.percentile(0.95)},
            {"p99_m", s.percentile(0.99)},
            {"worst", {{"lon", s.worst().lon}, {"lat", s.worst().lat}}}};
  if (const auto& e = s.excess())
    json["excess"] = {
        {"bound_m", e->bound_m}, {"error_m", e->error_m}, {"lon", e->place.lon}, {"lat", e->place.lat}};
  return json;
}

Json levels_of(const std::vector<PackLevel>& levels) {
  Json json = Json::array();
  for (const PackLevel& level : levels) {
    if (level.layer == Layer::heights)
      json.push_back({{"level", level.level}, {"max_error_m", static_cast<double>(level.max_error_m)}});
  }
  return json;
}

Json source_of(const RasterInfo& info, std::uint64_t hash) {
  Json source{{"name", info.path.filename().string()},
              {"format", info.format},
              {"columns", info.columns},
              {"rows", info.rows},
              {"bounds", json_of(info.bounds)},
              {"xxh3", fmt::format("{:016x}", hash)}};
  if (const auto& transform = info.georeference.transform) {
    source["crs"] = transform->name();
    source["operation"] = transform->operation();
  }
  if (!info.unit.empty()) source["unit"] = info.unit;
  if (info.vertical) source["vertical_crs"] = info.vertical->name;
  if (info.overrides != SourceOverrides{}) source["overrides"] = to_json(info.overrides);
  return source;
}

bool touches_region(const std::optional<GeoBounds>& region, const GeoBounds& bounds) {
  if (!region) return true;
  Footprint wanted;
  wanted.add(*region);
  return wanted.overlaps(bounds);
}

std::uint64_t count_of(const std::vector<std::uint64_t>& counts, std::size_t source) {
  return source < counts.size() ? counts[source] : 0;
}

// By source.
std::vector<double> error_bounds_of(const Mosaic& mosaic) {
  std::vector<double> bounds(mosaic.pool().size());
  for (std::size_t g = 0; g < mosaic.groups().size(); ++g)
    for (const std::size_t s : mosaic.groups()[g]->sources()) bounds[s] = mosaic.error_bound_m(g);
  return bounds;
}

// Sources of which no post lies where tiles are baked are not named. `hashes` are those of all inputs, the
// DEMs' first.
Json sources_of(const Mosaic& mosaic, const HeightPlan& plan, const HeightSummary& heights,
                const std::vector<std::uint64_t>& hashes) {
  Json sources = Json::array();
  const std::vector<double> bounds = error_bounds_of(mosaic);
  for (std::size_t s = 0; s < mosaic.pool().size(); ++s) {
    const std::uint64_t used = count_of(heights.posts_used, s), lost = count_of(heights.posts_lost, s);
    if (used == 0 && lost == 0) continue;
    Json source = source_of(mosaic.pool().info(s), hashes[s]);
    source["posts_used"] = used;
    source["posts_lost"] = lost;
    if (plan.least_error_bound_m() < plan.error_bound_m()) source["error_bound_m"] = bounds[s];
    sources.push_back(std::move(source));
  }
  return sources;
}

// A level's PSNR is that of the mean squared error of its tiles.
Result<Json> imagery_levels_of(const PackWriter& pack) {
  struct Level {
    std::uint64_t tiles = 0;
    double error = 0;
  };
  std::map<int, Level> levels;
  const Status status = pack.visit_entries([&levels](const IndexEntry& e) -> Status {
    if (e.layer != Layer::imagery) return {};
    ++levels[e.id.level].tiles;
    if (e.max_quanta < kNoTextureError) levels[e.id.level].error += std::pow(10, -e.max_quanta / 10'000.0);
    return {};
  });
  if (!status) return status.error();
  Json json = Json::array();
  for (const auto& [number, level] : levels) {
    const double worst = std::pow(10, -kNoTextureError / 10'000.0);
    const double mean = std::max(worst, level.error / static_cast<double>(level.tiles));
    json.push_back(
        {{"level", number}, {"tiles", level.tiles}, {"psnr_db", std::round(-1e4 * std::log10(mean)) / 1e3}});
  }
  return json;
}

// `options` are the imagery's of to_json().
Json imagery_of(const BakePlan& layers, const Json& options, const std::optional<GeoBounds>& region,
                const std::vector<std::uint64_t>& hashes, const Json& levels) {
  const std::size_t first = layers.heights ? layers.heights->pool().size() : 0;
  const RasterPool& pool = layers.imagery->pool();
  Json sources = Json::array();
  for (std::size_t s = 0; s < pool.size(); ++s)
    if (touches_region(region, pool.info(s).bounds))
      sources.push_back(source_of(pool.info(s), hashes[first + s]));
  return {{"format", options["format"]},
          {"quality", options["quality"]},
          {"feather_pixels", options["feather_pixels"]},
          {"top", layers.imagery_tree->top()},
          {"finest", layers.imagery->finest_level()},
          {"bounds", json_of(cut_to(region, layers.imagery->bounds()))},
          {"levels", levels},
          {"sources", sources}};
}

// The hashes of places and models are the last of all inputs.
Json objects_of(const ObjectSummary& summary, const BuildOptions& options,
                const std::vector<std::uint64_t>& hashes) {
  Json models = Json::array();
  for (const ObjectSummary::Model& model : summary.models)
    models.push_back({{"name", model.name},
                      {"objects", model.objects},
                      {"triangles", model.triangles},
                      {"vertices", model.vertices},
                      {"levels", model.levels}});
  const auto files = files_of(options.objects);
  Json sources = Json::array();
  for (std::size_t f = 0; f < files.size(); ++f)
    sources.push_back({{"name", files[f].filename().string()},
                       {"xxh3", fmt::format("{:016x}", hashes[hashes.size() - files.size() + f])}});
  Json objects = {{"objects", summary.objects}, {"left_out", summary.left_out}};
  if (summary.scattered + summary.outside_limits != 0) {
    objects["scattered"] = summary.scattered;
    objects["outside_limits"] = summary.outside_limits;
  }
  objects["models"] = models;
  objects["sources"] = sources;
  return objects;
}

}  // namespace

GeoBounds cut_to(const std::optional<GeoBounds>& region, const GeoBounds& bounds) {
  if (!region) return bounds;
  std::optional<GeoBounds> all;
  for (const double turn : {-360.0, 0.0, 360.0}) {
    const GeoBounds cut{std::max(bounds.west + turn, region->west), std::max(bounds.south, region->south),
                        std::min(bounds.east + turn, region->east), std::min(bounds.north, region->north)};
    if (cut.width() <= 0 || cut.height() <= 0) continue;
    all = all ? GeoBounds{std::min(all->west, cut.west), cut.south, std::max(all->east, cut.east), cut.north}
              : cut;
  }
  if (!all) return bounds;
  const double turns = 360 * std::floor((all->west + 180) / 360);
  return {all->west - turns, all->south, all->east - turns, all->north};
}

Result<std::string> describe_pack(const BakePlan& layers, const BuildOptions& options,
                                  const HeightSummary& heights, const std::optional<ObjectSummary>& objects,
                                  const std::vector<std::uint64_t>& input_hashes, const PackWriter& pack) {
  const Json stated = to_json(options);
  Json meta;
  meta["cairn"] = CAIRN_VERSION;
  meta["grid"] = {{"tile_size", options.grid.tile_size}};
  if (layers.plan) {
    meta["grid"]["quantum_m"] = layers.plan->quantum_m();
    meta["grid"]["top"] = layers.plan->top();
    meta["grid"]["finest"] = layers.plan->finest();
  }
  const MosaicDatum datum = layers.heights ? layers.heights->datum() : MosaicDatum{};
  const std::string other_datum = other_datum_of(datum);
  meta["vertical_datum"] = other_datum.empty() ? std::string(to_string(datum.datum)) : other_datum;
  if (!datum.vertical_crs.empty()) meta["vertical_crs"] = datum.vertical_crs;
  meta["bounds"] = json_of(cut_to(options.grid.region, layers.bounds()));
  if (layers.plan) {
    meta["error_bound_m"] = layers.plan->error_bound_m();
    if (layers.plan->least_error_bound_m() < layers.plan->error_bound_m())
      meta["least_error_bound_m"] = layers.plan->least_error_bound_m();
    meta["accuracy"] = json_of(heights.accuracy);
  }
  meta["levels"] = levels_of(pack.levels());
  meta["sources"] =
      layers.heights ? sources_of(*layers.heights, *layers.plan, heights, input_hashes) : Json::array();
  if (layers.imagery) {
    const Result<Json> levels = imagery_levels_of(pack);
    if (!levels) return levels.error();
    meta["imagery"] = imagery_of(layers, stated["imagery"], options.grid.region, input_hashes, *levels);
  }
  if (layers.plan && options.heights.rqt_tolerance_m)
    meta["rqt"] = {{"tolerance_m", *options.heights.rqt_tolerance_m}, {"triangulations", kRqtSteps}};
  if (objects) meta["objects"] = objects_of(*objects, options, input_hashes);
  meta["options"] = stated;
  // A file's name need not be UTF-8, JSON must.
  return meta.dump(1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace cairn
