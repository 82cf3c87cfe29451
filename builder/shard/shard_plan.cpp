#include "builder/shard/shard_plan.h"

#include <charconv>
#include <cstdio>
#include <fstream>
#include <span>

#include <fmt/format.h>

#include "builder/raster/raster_info_json.h"
#include "format/checksum.h"
#include "format/file.h"

namespace cairn {
namespace {

using SortedJson = nlohmann::json;
namespace fs = std::filesystem;

constexpr int kPlanVersion = 1;

std::uint64_t number_from_hex(const SortedJson& json) {
  const auto text = json.get<std::string>();
  std::uint64_t number = 0;
  std::from_chars(text.data(), text.data() + text.size(), number, 16);
  return number;
}

SortedJson json_of(const PlannedFile& file) {
  SortedJson json{{"path", file.path.string()}, {"bytes", file.bytes}, {"xxh3", hex_of(file.hash)}};
  for (const PlannedFile& other : file.beside) json["beside"].push_back(json_of(other));
  return json;
}

PlannedFile file_from(const SortedJson& json) {
  PlannedFile file{json.at("path").get<std::string>(),
                   json.at("bytes").get<std::uint64_t>(),
                   number_from_hex(json.at("xxh3")),
                   {}};
  if (json.contains("beside"))
    for (const SortedJson& other : json.at("beside")) file.beside.push_back(file_from(other));
  return file;
}

SortedJson json_of(const ShardTiles& tiles) {
  SortedJson json{{"leaves", tiles.leaves}, {"subtrees", SortedJson::array()}};
  for (const TileId& id : tiles.subtrees) json["subtrees"].push_back({id.level, id.x, id.y});
  return json;
}

ShardTiles tiles_from(const SortedJson& json) {
  ShardTiles tiles;
  tiles.leaves = json.at("leaves").get<std::uint64_t>();
  for (const SortedJson& id : json.at("subtrees")) {
    tiles.subtrees.push_back(
        {id.at(0).get<int>(), id.at(1).get<std::int32_t>(), id.at(2).get<std::int32_t>()});
  }
  return tiles;
}

SortedJson json_of(const Shard& shard) {
  return {{"heights", json_of(shard.heights)},
          {"imagery", json_of(shard.imagery)},
          {"files", shard.files},
          {"estimated_bytes", shard.estimated_bytes},
          {"estimated_seconds", shard.estimated_seconds},
          {"key", hex_of(shard.key)}};
}

SortedJson json_of(const ShardPlan& plan) {
  SortedJson json{
      {"cairn_plan", kPlanVersion},      {"cairn", plan.version},         {"options", plan.options},
      {"allow_error", plan.allow_error}, {"with_geoid", plan.with_geoid}, {"memory_bytes", plan.memory_bytes},
      {"files", SortedJson::array()},    {"dems", SortedJson::array()},   {"images", SortedJson::array()},
      {"has_voids", plan.has_voids},     {"shards", SortedJson::array()}};
  if (plan.places > 0)
    json["objects"] = {{"places", plan.places}, {"models", {{"path", plan.models.string()}}}};
  for (const PlannedFile& file : plan.files) json["files"].push_back(json_of(file));
  for (const RasterInfo& info : plan.dems) json["dems"].push_back(to_json(info));
  for (const RasterInfo& info : plan.images) json["images"].push_back(to_json(info));
  for (const Shard& shard : plan.shards) {
    json["shards"].push_back(json_of(shard));
    json["shards"].back()["number"] = json["shards"].size() - 1;
  }
  return json;
}

// The folders may be other ones on another machine.
void drop_folders(SortedJson& json) {
  if (json.is_object() && json.contains("path"))
    json["path"] = fs::path(json["path"].get<std::string>()).filename().string();
  if (json.is_structured())
    for (auto& member : json) drop_folders(member);
}

std::uint64_t text_hash_of(const SortedJson& json) {
  const std::string text = json.dump();
  return checksum(std::as_bytes(std::span(text)));
}

std::uint64_t id_of(SortedJson json) {
  json.erase("id");
  drop_folders(json);
  return text_hash_of(json);
}

// Where the sources lie, and what is chosen by all of them together, decides every part; the bytes of those
// alone that the shard reads.
SortedJson common_of(const SortedJson& plan) {
  SortedJson common;
  for (const char* member : {"cairn", "options", "allow_error", "with_geoid", "dems", "images"})
    common[member] = plan.at(member);
  common["options"].erase("objects");
  common["options"].erase("rqt");
  drop_folders(common);
  return common;
}

std::uint64_t key_of(const ShardPlan& plan, const Shard& shard, std::uint64_t common) {
  SortedJson json{
      {"common", common}, {"heights", json_of(shard.heights)}, {"imagery", json_of(shard.imagery)}};
  for (const std::size_t file : shard.files) {
    json["files"].push_back(json_of(plan.files[file]));
    json["voids"].push_back(file < plan.has_voids.size() ? plan.has_voids[file] : 0);
  }
  drop_folders(json);
  return text_hash_of(json);
}

ShardPlan plan_from(const SortedJson& json) {
  ShardPlan plan;
  plan.version = json.at("cairn").get<std::string>();
  plan.options = json.at("options");
  plan.allow_error = json.at("allow_error").get<bool>();
  plan.with_geoid = json.at("with_geoid").get<bool>();
  plan.memory_bytes = json.at("memory_bytes").get<std::uint64_t>();
  plan.has_voids = json.at("has_voids").get<std::vector<std::uint8_t>>();
  if (json.contains("objects")) {
    plan.places = json.at("objects").at("places").get<std::size_t>();
    plan.models = json.at("objects").at("models").at("path").get<std::string>();
  }
  for (const SortedJson& file : json.at("files")) plan.files.push_back(file_from(file));
  for (const SortedJson& shard : json.at("shards")) {
    plan.shards.push_back({tiles_from(shard.at("heights")), tiles_from(shard.at("imagery")),
                           shard.at("files").get<std::vector<std::size_t>>(),
                           shard.at("estimated_bytes").get<std::uint64_t>(),
                           shard.at("estimated_seconds").get<double>(), number_from_hex(shard.at("key"))});
  }
  return plan;
}

Status read_sources(const SortedJson& json, std::vector<RasterInfo>& sources) {
  for (const SortedJson& source : json) {
    auto info = raster_info_from(source);
    if (!info) return info.error();
    sources.push_back(std::move(*info));
  }
  return {};
}

Status check_numbers(const ShardPlan& plan) {
  const std::size_t files = plan.first_of_objects();
  bool right = plan.has_voids.size() == plan.dems.size() &&
               (plan.places == 0 ? plan.files.size() == files : plan.files.size() >= files + plan.places);
  for (const Shard& shard : plan.shards) {
    for (const std::size_t file : shard.files) right = right && file < files;
    for (const ShardTiles* tiles : {&shard.heights, &shard.imagery})
      for (const TileId& id : tiles->subtrees) right = right && is_valid(id);
  }
  return right ? Status() : Status(bad_data("files: expected one for each source, found others"));
}

}  // namespace

std::string hex_of(std::uint64_t number) {
  return fmt::format("{:016x}", number);
}

Status write_shard_plan(ShardPlan& plan, const fs::path& target) {
  const fs::path part = fs::path(target).concat(".part");
  try {
    const std::uint64_t common = text_hash_of(common_of(json_of(plan)));
    for (Shard& shard : plan.shards) shard.key = key_of(plan, shard, common);
    SortedJson json = json_of(plan);
    plan.id = id_of(json);
    json["id"] = hex_of(plan.id);
    std::ofstream out(part, std::ios::binary);
    out << json.dump(1) << '\n';
    if (!out.flush()) return failed(part.string() + ": plan: expected to write it, found an unwritable file");
  } catch (const SortedJson::exception&) {
    return bad_data(target.string() + ": plan: expected names of files in UTF-8, found others");
  }
  return rename_durably(part, target);
}

Result<ShardPlan> read_shard_plan(const fs::path& path) {
  const std::string name = path.string();
  std::ifstream in(path, std::ios::binary);
  if (!in) return failed(name + ": plan: expected a file that can be read, found none");
  const SortedJson json = SortedJson::parse(in, nullptr, false);
  if (!json.is_object() || json.value("cairn_plan", SortedJson()) != kPlanVersion)
    return bad_data(name + ": plan: expected a plan of this program, found another file");
  ShardPlan plan;
  try {
    const auto version = json.at("cairn").get<std::string>();
    if (version != CAIRN_VERSION)
      return bad_data(name + ": plan: expected one of cairn " CAIRN_VERSION ", found one of cairn " +
                      version);
    plan.id = number_from_hex(json.at("id"));
    const std::uint64_t found = id_of(json);
    if (found != plan.id)
      return bad_data(name + ": plan: expected its id to be " + hex_of(found) + ", found " + hex_of(plan.id) +
                      ": it was changed or damaged");
    const std::uint64_t id = plan.id;
    plan = plan_from(json);
    plan.id = id;
    if (auto status = read_sources(json.at("dems"), plan.dems); !status)
      return bad_data(name + ": " + status.error().message);
    if (auto status = read_sources(json.at("images"), plan.images); !status)
      return bad_data(name + ": " + status.error().message);
  } catch (const std::exception& error) {
    return bad_data(name + ": plan: " + error.what());
  }
  if (auto status = check_numbers(plan); !status) return bad_data(name + ": " + status.error().message);
  return plan;
}

}  // namespace cairn
