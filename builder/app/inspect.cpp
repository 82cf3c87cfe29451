#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <nlohmann/json.hpp>

#include "builder/app/report_error.h"
#include "builder/app/verbs.h"
#include "builder/raster/expand_inputs.h"
#include "builder/raster/inspect_raster.h"
#include "builder/raster/raster_source.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

struct InspectOptions {
  std::vector<std::string> inputs;
  InputSearch search;
  bool json = false;
};

std::string crs_name(const Georeference& g) {
  switch (g.crs) {
    case Georeference::Crs::geographic:
      return "longitude and latitude";
    case Georeference::Crs::utm:
      return fmt::format("UTM zone {}{}", g.utm_zone, g.utm_north ? "N" : "S");
    case Georeference::Crs::web_mercator:
      return "Web Mercator";
    case Georeference::Crs::other:
      break;
  }
  return g.transform ? g.transform->name() : g.definition;
}

Json describe(const RasterInfo& info) {
  const LonLat first = info.georeference.place_of(0, 0), next = info.georeference.place_of(1, 1);
  Json json{{"name", info.path.string()},
            {"format", info.format},
            {"columns", info.columns},
            {"rows", info.rows},
            {"bands", info.bands},
            {"type", to_string(info.type)},
            {"bounds",
             {{"west", info.bounds.west},
              {"south", info.bounds.south},
              {"east", info.bounds.east},
              {"north", info.bounds.north}}},
            {"first_post", {{"lon", first.lon}, {"lat", first.lat}}},
            {"spacing_degrees", {{"lon", next.lon - first.lon}, {"lat", next.lat - first.lat}}}};
  json["nodata"] = info.nodata ? Json(*info.nodata) : Json();
  json["crs"] = crs_name(info.georeference);
  json["body"] = info.body.name;
  json["vertical_crs"] = info.vertical ? Json(info.vertical->name) : Json();
  json["unit"] = info.unit.empty() ? "m" : info.unit;
  return json;
}

Json describe(const RasterFindings& found) {
  Json json{{"posts", found.posts},
            {"voids", found.voids},
            {"lowest_m", found.lowest_m},
            {"highest_m", found.highest_m},
            {"only_whole_metres", found.only_whole_metres},
            {"level_posts", found.level_posts},
            {"level_m", found.level_m},
            {"spikes", found.spikes}};
  json["highest_spikes"] = Json::array();
  for (const OddPlace& spike : found.highest_spikes)
    json["highest_spikes"].push_back({{"column", spike.column},
                                      {"row", spike.row},
                                      {"lon", spike.place.lon},
                                      {"lat", spike.place.lat},
                                      {"metres", spike.metres}});
  json["steps"] = Json::array();
  for (const HeightStep& step : found.steps)
    json["steps"].push_back(
        {{step.between_columns ? "after_column" : "after_row", step.before}, {"metres", step.metres}});
  return json;
}

double percent(std::uint64_t part, std::uint64_t all) {
  return all > 0 ? 100.0 * static_cast<double>(part) / static_cast<double>(all) : 0;
}

void print_text(const RasterInfo& info, const RasterFindings& found) {
  const LonLat first = info.georeference.place_of(0, 0), next = info.georeference.place_of(1, 1);
  fmt::print("{}\n  {}: {} x {} posts, {}{}\n", info.path.string(), info.format, info.columns, info.rows,
             to_string(info.type), info.nodata ? fmt::format(", nodata {}", *info.nodata) : "");
  fmt::print("  west {} south {} east {} north {}, about {:.6g} x {:.6g} degrees from post to post\n",
             info.bounds.west, info.bounds.south, info.bounds.east, info.bounds.north, next.lon - first.lon,
             first.lat - next.lat);
  fmt::print("  CRS: {}{}; heights in {} above {}\n", crs_name(info.georeference),
             info.body.is_earth() ? "" : " on " + info.body.name, info.unit.empty() ? "m" : info.unit,
             info.vertical ? info.vertical->name : "an unknown datum");
  if (found.voids == found.posts) {
    fmt::print("  all posts are void\n");
    return;
  }
  fmt::print("  heights {:g} to {:g} m{}, {:.2f} % void\n", found.lowest_m, found.highest_m,
             found.only_whole_metres ? ", whole metres" : "", percent(found.voids, found.posts));
  if (found.level_posts > 0)
    fmt::print("  level: {:.2f} % of the posts, most at {:g} m\n", percent(found.level_posts, found.posts),
               found.level_m);
  if (found.spikes > 0) fmt::print("  spikes: {}\n", found.spikes);
  for (const OddPlace& spike : found.highest_spikes)
    fmt::print("    {:+.1f} m at lon {:.6f} lat {:.6f} (column {}, row {})\n", spike.metres, spike.place.lon,
               spike.place.lat, spike.column, spike.row);
  for (const HeightStep& step : found.steps)
    fmt::print("  step: {:+.2f} m behind {} {}\n", step.metres, step.between_columns ? "column" : "row",
               step.before);
}

Result<std::unique_ptr<RasterSource>> open_one(const std::filesystem::path& path) {
  constexpr std::size_t kCacheBytes = 8 << 20;
  return open_raster(path, {.bounds = {}, .cache_bytes = kCacheBytes});
}

Result<Seam> compare_files(const RasterInfo& first, const RasterInfo& second) {
  const auto one = open_one(first.path), other = open_one(second.path);
  if (!one) return one.error();
  if (!other) return other.error();
  return compare_rasters(**one, **other);
}

/// Each pair of rasters whose bounds touch.
Status inspect_seams(const std::vector<RasterInfo>& rasters, bool as_json, Json& seams) {
  for (std::size_t i = 0; i < rasters.size(); ++i) {
    for (std::size_t k = i + 1; k < rasters.size(); ++k) {
      if (!rasters[i].bounds.touches(rasters[k].bounds)) continue;
      const auto seam = compare_files(rasters[i], rasters[k]);
      if (!seam) return seam.error();
      if (seam->posts == 0) continue;
      const std::string one = rasters[i].path.string(), other = rasters[k].path.string();
      seams.push_back({{"first", one},
                       {"second", other},
                       {"posts", seam->posts},
                       {"mean_m", seam->mean_m},
                       {"max_m", seam->max_m}});
      if (!as_json)
        fmt::print("{} and {}: {} posts in common, the second {:+.3f} m on average, at most {:.3f} m off\n",
                   one, other, seam->posts, seam->mean_m, seam->max_m);
    }
  }
  return {};
}

Status inspect(const InspectOptions& options) {
  const auto inputs = expand_inputs(options.inputs, options.search);
  if (!inputs) return inputs.error();
  std::vector<RasterInfo> rasters;
  Json report{{"rasters", Json::array()}, {"seams", Json::array()}};
  for (const auto& path : inputs->files) {
    const auto raster = open_one(path);
    if (!raster) return raster.error();
    const auto found = inspect_raster(**raster);
    if (!found) return found.error();
    rasters.push_back((*raster)->info());
    if (!options.json) print_text(rasters.back(), *found);
    Json described = describe(rasters.back());
    described.update(describe(*found));
    report["rasters"].push_back(std::move(described));
  }
  if (auto status = inspect_seams(rasters, options.json, report["seams"]); !status) return status;
  if (options.json) fmt::print("{}\n", report.dump(1, ' ', false, Json::error_handler_t::replace));
  return {};
}

}  // namespace

void add_inspect(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<InspectOptions>();
  CLI::App* verb = app.add_subcommand(
      "inspect", "Say what DEMs hold and what is odd in them: voids, spikes, steps, seams");
  verb->add_option("dem", options->inputs, "DEM files, folders, glob patterns or @LIST")->required();
  verb->add_flag("--recursive", options->search.recursive, "search folders with all folders in them");
  verb->add_flag("--json", options->json, "Print JSON");
  verb->callback([options, &exit_code] {
    const Status status = inspect(*options);
    exit_code = status ? 0 : report_error(status.error());
  });
}

}  // namespace cairn
