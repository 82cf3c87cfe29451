#include "builder/build_metadata.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/fingerprint.h"

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const GeoBounds& b) {
  return {{"west", b.west}, {"south", b.south}, {"east", b.east}, {"north", b.north}};
}

Json json_of(const PostStats& s) {
  return {{"posts", s.count()},
          {"max_m", s.max()},
          {"rms_m", s.rms()},
          {"p50_m", s.percentile(0.50)},
          {"p95_m", s.percentile(0.95)},
          {"p99_m", s.percentile(0.99)},
          {"worst", {{"lon", s.worst().lon}, {"lat", s.worst().lat}}}};
}

Json levels_of(const std::vector<IndexEntry>& entries) {
  std::map<int, double> worst;
  for (const IndexEntry& e : entries) {
    if (e.layer != Layer::heights) continue;
    double& error = worst[e.id.level];
    error = std::max(error, static_cast<double>(e.geometric_error_m));
  }
  Json levels = Json::array();
  for (const auto& [level, error] : worst) levels.push_back({{"level", level}, {"max_error_m", error}});
  return levels;
}

Json sources_of(const Mosaic& mosaic, const HeightSummary& heights,
                const std::vector<std::uint64_t>& hashes) {
  Json sources = Json::array();
  for (std::size_t s = 0; s < mosaic.pool().size(); ++s) {
    const RasterInfo& info = mosaic.pool().info(s);
    sources.push_back({{"name", info.path.filename().string()},
                       {"format", info.format},
                       {"columns", info.columns},
                       {"rows", info.rows},
                       {"bounds", json_of(info.bounds)},
                       {"xxh3", fmt::format("{:016x}", hashes[s])},
                       {"posts_won", s < heights.posts_won.size() ? heights.posts_won[s] : 0}});
  }
  return sources;
}

const char* name_of(ResampleMethod method) {
  switch (method) {
    case ResampleMethod::nearest:
      return "nearest";
    case ResampleMethod::bilinear:
      return "bilinear";
    case ResampleMethod::cubic:
      return "cubic";
    case ResampleMethod::exact:
      return "exact";
  }
  return "";
}

Json options_of(const BuildOptions& o) {
  Json options{{"tile_size", o.tile_size},
               {"resampling", name_of(o.resampling)},
               {"void", o.voids == VoidMode::fill ? "fill" : "keep"},
               {"datum", to_string(o.datum)}};
  if (o.level) options["level"] = *o.level;
  if (o.top) options["top"] = *o.top;
  if (o.region) options["region"] = json_of(*o.region);
  if (o.max_error_m) options["max_error"] = *o.max_error_m;
  if (o.quantum_m) options["quantum"] = *o.quantum_m;
  return options;
}

}  // namespace

std::string describe_pack(const Mosaic& mosaic, const BuildPlan& plan, const BuildOptions& options,
                          const HeightSummary& heights, const std::vector<std::uint64_t>& input_hashes,
                          const std::vector<IndexEntry>& entries) {
  Json meta;
  meta["cairn"] = CAIRN_VERSION;
  meta["grid"] = {{"tile_size", plan.tile_size()},
                  {"quantum_m", plan.quantum_m()},
                  {"top", plan.top()},
                  {"finest", plan.finest()}};
  meta["vertical_datum"] = to_string(options.geoid ? VerticalDatum::ellipsoid : options.datum);
  meta["bounds"] = json_of(mosaic.bounds());
  meta["promise_m"] = plan.promise_m();
  meta["accuracy"] = json_of(heights.accuracy);
  meta["levels"] = levels_of(entries);
  meta["sources"] = sources_of(mosaic, heights, input_hashes);
  meta["options"] = options_of(options);
  return meta.dump(1);
}

}  // namespace cairn
