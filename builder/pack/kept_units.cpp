#include "builder/pack/kept_units.h"

#include <algorithm>
#include <span>
#include <string>
#include <system_error>
#include <utility>

#include "builder/bake/bake_target.h"
#include "builder/objects/object_layer.h"
#include "builder/pack/options_json.h"
#include "cairn/pack_reader.h"
#include "format/bytes.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

// Absolute, so that the file is found from another folder; a name of GDAL's stays as it is.
std::string lasting_name(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) return path.string();
  const fs::path absolute = fs::absolute(path, error);
  return error ? path.string() : absolute.lexically_normal().string();
}

nlohmann::json json_of(const fs::path& path, std::uint64_t hash, bool has_voids) {
  return {{"path", lasting_name(path)}, {"xxh3", hash}, {"has_voids", has_voids}};
}

KeptUnits::Source source_from(const nlohmann::json& json) {
  return {json.at("path").get<std::string>(), json.at("xxh3").get<std::uint64_t>(),
          json.at("has_voids").get<bool>()};
}

nlohmann::json describe(const PackId& pack, const BakePlan& layers, const BuildOptions& options,
                        const std::vector<std::uint64_t>& hashes) {
  nlohmann::json json{{"cairn_units", 1},
                      {"cairn", CAIRN_VERSION},
                      {"pack", to_string(pack)},
                      {"options", to_json(options)},
                      {"allow_error", options.heights.allow_error},
                      {"dems", nlohmann::json::array()},
                      {"images", nlohmann::json::array()}};
  std::size_t file = 0;
  for (std::size_t s = 0; s < options.mosaic.inputs.size(); ++s, ++file)
    json["dems"].push_back(
        json_of(options.mosaic.inputs[s], hashes[file], layers.heights->pool().has_voids(s)));
  for (std::size_t s = 0; s < options.imagery.inputs.size(); ++s, ++file)
    json["images"].push_back(json_of(options.imagery.inputs[s], hashes[file], false));
  if (options.mosaic.geoid) json["geoid"] = json_of(*options.mosaic.geoid, hashes[file++], false);
  if (options.objects.places.empty()) return json;
  json["models"] = lasting_name(options.objects.models);
  const std::size_t first_model = file + options.objects.places.size();
  for (const fs::path& path : files_of(options.objects)) {
    json[file < first_model ? "places" : "model_files"].push_back(json_of(path, hashes[file], false));
    ++file;
  }
  return json;
}

void append_keys(const std::vector<UnitKey>& keys, ByteWriter& writer) {
  writer.write(static_cast<std::uint64_t>(keys.size()));
  for (const UnitKey& key : keys) {
    writer.write(std::int32_t{key.unit.level});
    writer.write(key.unit.x);
    writer.write(key.unit.y);
    writer.append(key.hash);
    writer.write(static_cast<std::uint32_t>(key.sources.size()));
    for (const std::uint32_t source : key.sources) writer.write(source);
  }
}

bool read_keys(ByteReader& in, std::vector<UnitKey>& keys) {
  for (auto n = in.read<std::uint64_t>(); n > 0 && in.ok(); --n) {
    UnitKey& key = keys.emplace_back();
    key.unit.level = in.read<std::int32_t>();
    key.unit.x = in.read<std::int32_t>();
    key.unit.y = in.read<std::int32_t>();
    const auto hash = in.take(key.hash.size());
    if (!in.ok() || !is_valid(key.unit)) return false;
    std::copy(hash.begin(), hash.end(), key.hash.begin());
    for (auto s = in.read<std::uint32_t>(); s > 0 && in.ok(); --s)
      key.sources.push_back(in.read<std::uint32_t>());
  }
  return in.ok();
}

// The last record: a description, then the keys.
bool read_last(std::span<const std::byte> bytes, KeptUnits& kept) {
  ByteReader in(bytes);
  const auto text = in.take(in.read<std::uint64_t>());
  if (!in.ok()) return false;
  const auto* characters = reinterpret_cast<const char*>(text.data());
  const nlohmann::json json = nlohmann::json::parse(characters, characters + text.size(), nullptr, false);
  if (!json.is_object() || json.value("cairn_units", nlohmann::json()) != 1 ||
      json.value("cairn", "") != CAIRN_VERSION)
    return false;
  try {
    const auto id = json.at("pack").get<std::string>();
    if (to_string(kept.pack) != id) return false;
    kept.options = json.at("options");
    kept.allow_error = json.at("allow_error").get<bool>();
    for (const nlohmann::json& source : json.at("dems")) kept.dems.push_back(source_from(source));
    for (const nlohmann::json& source : json.at("images")) kept.images.push_back(source_from(source));
    if (json.contains("geoid")) kept.geoid = source_from(json.at("geoid"));
    if (json.contains("models")) {
      kept.models = json.at("models").get<std::string>();
      for (const nlohmann::json& source : json.at("places")) kept.places.push_back(source_from(source));
      for (const nlohmann::json& source : json.at("model_files"))
        kept.model_files.push_back(source_from(source));
    }
  } catch (const nlohmann::json::exception&) {
    return false;
  }
  return read_keys(in, kept.keys.heights) && read_keys(in, kept.keys.imagery) && in.remaining() == 0;
}

}  // namespace

Status keep_units(BakeSession& session, const BakePlan& layers, const BuildOptions& options,
                  const std::vector<std::uint64_t>& hashes) {
  const fs::path& target = options.session.target;
  const auto pack = PackReader::open(target);
  if (!pack) return pack.error();
  // Which sources have voids is not known of units that an interrupted bake had made.
  if (session.resumed && layers.heights)
    for (std::size_t s = 0; s < layers.heights->pool().size(); ++s) layers.heights->pool().expect_voids(s);
  std::string text;
  try {
    text = describe(pack->header().id, layers, options, hashes).dump();
  } catch (const nlohmann::json::exception&) {  // names of files that are no UTF-8
    remove_journal(target);
    return {};
  }
  UnitRecord last;
  ByteWriter writer(last.root);
  writer.write(static_cast<std::uint64_t>(text.size()));
  writer.append(std::as_bytes(std::span(text)));
  const UnitKeys keys = unit_keys(layers, options, hashes);
  append_keys(keys.heights, writer);
  append_keys(keys.imagery, writer);
  if (auto status = session.journal.append(last); !status) return status;
  return session.journal.keep_as(units_path(target));
}

std::optional<KeptUnits> read_kept_units(const fs::path& pack_path) {
  const auto pack = PackReader::open(pack_path);
  auto records = JournalReader::open(units_path(pack_path));
  if (!pack || !records) return std::nullopt;
  std::vector<RecordPlace> places;
  std::vector<std::byte> last;
  while (true) {
    const std::uint64_t start = records->position();
    auto record = records->next();
    if (!record) return std::nullopt;
    if (!*record) break;
    places.push_back({start, records->position()});
    last = std::move((*record)->root);
  }
  KeptUnits kept;
  kept.pack = pack->header().id;
  if (places.empty() || !read_last(last, kept)) return std::nullopt;
  const std::size_t heights = kept.keys.heights.size(), imagery = kept.keys.imagery.size();
  if (places.size() < heights + imagery + 1) return std::nullopt;
  const auto at = [&](std::size_t n) { return places.begin() + static_cast<std::ptrdiff_t>(n); };
  kept.heights.assign(at(0), at(heights));
  kept.imagery.assign(at(heights), at(heights + imagery));
  return kept;
}

}  // namespace cairn
