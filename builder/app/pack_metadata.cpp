#include "builder/app/pack_metadata.h"

#include <algorithm>
#include <map>
#include <string>
#include <unordered_set>

#include <nlohmann/json.hpp>

namespace cairn {

namespace {

using Json = nlohmann::ordered_json;

double samples_a_tile(const PackReader& pack, Layer layer) {
  const double side = pack.header().tile_size - (layer == Layer::imagery ? 1 : 0);
  return side * side;
}

Json levels_json(const PackReader& pack, Layer layer) {
  Json levels = Json::array();
  for (const LevelSummary& level : summarise_levels(pack, layer)) {
    const double samples = static_cast<double>(level.tiles) * samples_a_tile(pack, layer);
    levels.push_back({{"level", level.level},
                      {"tiles", level.tiles},
                      {"constant_tiles", level.constant_tiles},
                      {"bytes", level.bytes},
                      {"bits_per_sample", static_cast<double>(level.bytes) * 8 / samples},
                      {"max_error_m", level.max_error_m}});
  }
  return levels;
}

// The index says what there is, the metadata what was measured.
Json imagery_json(const PackReader& pack, const nlohmann::json& metadata) {
  const auto measured = [&](const std::string& pointer) {
    const nlohmann::json::json_pointer path("/imagery" + pointer);
    return metadata.contains(path) ? metadata.at(path) : nlohmann::json();
  };
  Json levels = levels_json(pack, Layer::imagery);
  for (std::size_t i = 0; i < levels.size(); ++i) {
    levels[i].erase("max_error_m");
    levels[i]["psnr_db"] = measured("/levels/" + std::to_string(i) + "/psnr_db");
  }
  return {{"format", measured("/format")},
          {"quality", measured("/quality")},
          {"levels", levels},
          {"sources", measured("/sources")}};
}

// A sample is one of the heights that are triangulated.
Json rqt_json(const PackReader& pack) {
  Json levels = levels_json(pack, Layer::rqt);
  std::map<int, std::uint64_t> triangles;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer == Layer::rqt) triangles[entry.id.level] += static_cast<std::uint64_t>(entry.max_quanta);
  }
  for (Json& level : levels) {
    level["tolerance_m"] = level["max_error_m"];
    level["triangles"] = triangles[level["level"].get<int>()];
    level.erase("max_error_m");
    level.erase("constant_tiles");
  }
  return {{"levels", levels}};
}

Json objects_json(const PackReader& pack, const nlohmann::json& metadata) {
  Json levels = levels_json(pack, Layer::objects);
  std::map<int, std::uint64_t> objects;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer == Layer::objects)
      objects[entry.id.level] += static_cast<std::uint64_t>(std::max(entry.min_quanta, 0));
  }
  std::uint64_t all = 0, bytes = 0;
  for (Json& level : levels) {
    level["objects"] = objects[level["level"].get<int>()];
    level["largest_m"] = level["max_error_m"];
    level.erase("max_error_m");
    level.erase("bits_per_sample");
    all += level["objects"].get<std::uint64_t>();
    bytes += level["bytes"].get<std::uint64_t>();
  }
  const auto stated = [&](const char* key) {
    const nlohmann::json::json_pointer path(std::string("/objects/") + key);
    return metadata.contains(path) ? metadata.at(path) : nlohmann::json();
  };
  std::uint64_t model_bytes = 0;
  for (const LevelSummary& level : summarise_levels(pack, Layer::models)) model_bytes += level.bytes;
  return {{"objects", all},
          {"bytes", bytes},
          {"left_out", stated("left_out")},
          {"scattered", stated("scattered")},
          {"outside_limits", stated("outside_limits")},
          {"levels", levels},
          {"model_bytes", model_bytes},
          {"models", stated("models")}};
}

}  // namespace

Result<nlohmann::json> parse_metadata(const PackReader& pack) {
  if (const Status status = pack.read_metadata(); !status) return status.error();
  nlohmann::json metadata = nlohmann::json::parse(pack.metadata_json(), nullptr, false);
  if (metadata.is_object()) return metadata;
  return bad_data(pack.path().string() + ": metadata: expected a JSON object, found " +
                  (metadata.is_discarded() ? "no JSON" : metadata.type_name()));
}

std::vector<LevelSummary> summarise_levels(const PackReader& pack, Layer layer) {
  std::vector<LevelSummary> levels;
  for (const PackLevel& level : pack.level_table()) {
    if (level.layer != layer) continue;
    levels.push_back({level.level, level.tiles, level.constant_tiles, level.block_bytes,
                      static_cast<double>(level.max_error_m)});
  }
  return levels;
}

nlohmann::ordered_json describe_pack_file(const PackReader& pack, const nlohmann::json& metadata) {
  const auto of = [&](const char* key) {
    return metadata.contains(key) ? metadata.at(key) : nlohmann::json();
  };
  const PackHeader& header = pack.header();
  Json info;
  info["format_version"] = header.version;
  info["id"] = to_string(header.id);
  info["tile_size"] = header.tile_size;
  info["quantum_m"] = header.quantum_m;
  info["body"] = {{"name", header.body.name},
                  {"semi_major_m", header.body.shape.semi_major_m},
                  {"semi_minor_m", header.body.shape.semi_minor_m}};
  info["vertical_datum"] = header.datum_name();
  info["bounds"] = of("bounds");
  info["error_bound_m"] = of("error_bound_m");
  if (metadata.contains("least_error_bound_m")) info["least_error_bound_m"] = of("least_error_bound_m");
  info["file_bytes"] = header.file_bytes();
  info["levels"] = levels_json(pack, Layer::heights);
  if (pack.levels(Layer::imagery)) info["imagery"] = imagery_json(pack, metadata);
  if (pack.levels(Layer::rqt)) info["rqt"] = rqt_json(pack);
  if (pack.levels(Layer::objects)) info["objects"] = objects_json(pack, metadata);
  info["accuracy"] = of("accuracy");
  info["sources"] = of("sources");
  return info;
}

}  // namespace cairn
