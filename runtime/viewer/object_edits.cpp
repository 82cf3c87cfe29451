#include "runtime/viewer/object_edits.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <system_error>
#include <utility>

#include <nlohmann/json.hpp>

#include "cairn/object_placing.h"
#include "format/file.h"

namespace cairn::viewer {
namespace {

using Json = nlohmann::json;

Error bad_placements(const std::filesystem::path& file, const std::string& place, const std::string& expected,
                     const std::string& found) {
  return bad_data(file.string() + ": " + place + ": expected " + expected + ", found " + found);
}

double number_of(const Json& properties, const char* name, double otherwise) {
  const auto found = properties.find(name);
  return found != properties.end() && found->is_number() ? found->get<double>() : otherwise;
}

Result<Placement> placement_of(const std::filesystem::path& file, const std::string& place,
                               const Json& feature) {
  const Json none = Json::object();
  const Json& geometry = feature.is_object() ? feature.value("geometry", none) : none;
  const Json& properties = feature.is_object() ? feature.value("properties", none) : none;
  const bool is_point = geometry.is_object() && geometry.value("type", Json()) == "Point" &&
                        geometry.contains("coordinates") && geometry["coordinates"].is_array() &&
                        geometry["coordinates"].size() >= 2 && geometry["coordinates"][0].is_number() &&
                        geometry["coordinates"][1].is_number();
  if (!is_point) return bad_placements(file, place, "a point", feature.dump().substr(0, 60));
  const bool has_model =
      properties.is_object() && properties.contains("model") && properties["model"].is_string();
  if (!has_model) return bad_placements(file, place, "a property `model`, a name", "none");
  Placement placement;
  placement.at = {geometry["coordinates"][0].get<double>(), geometry["coordinates"][1].get<double>()};
  placement.model = properties["model"].get<std::string>();
  placement.heading_deg = number_of(properties, "heading", 0);
  placement.scale = number_of(properties, "scale", 1);
  placement.feature = feature.dump();
  const bool is_in_range = std::abs(placement.at.lon) <= 180 && std::abs(placement.at.lat) <= 90 &&
                           std::isfinite(placement.heading_deg) && placement.scale > 0 &&
                           std::isfinite(placement.scale);
  if (!is_in_range)
    return bad_placements(file, place, "degrees of the Earth and a scale above 0",
                          feature.dump().substr(0, 60));
  return placement;
}

Json feature_of(const Placement& placement) {
  Json feature = placement.feature.empty() ? Json::object() : Json::parse(placement.feature);
  feature["type"] = "Feature";
  feature["geometry"]["type"] = "Point";
  Json& coordinates = feature["geometry"]["coordinates"];
  if (!coordinates.is_array() || coordinates.size() < 2) coordinates = Json::array({0, 0});
  coordinates[0] = placement.at.lon;
  coordinates[1] = placement.at.lat;
  feature["properties"]["model"] = placement.model;
  feature["properties"]["heading"] = placement.heading_deg;
  feature["properties"]["scale"] = placement.scale;
  return feature;
}

}  // namespace

std::filesystem::path placements_path(const std::filesystem::path& pack) {
  std::filesystem::path path = pack;
  path += ".objects.json";
  return path;
}

Result<ObjectEdits> ObjectEdits::open(std::filesystem::path file) {
  ObjectEdits edits(std::move(file));
  std::error_code error;
  if (!std::filesystem::exists(edits.file_, error) && !error) return edits;
  std::ifstream in(edits.file_, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(in), {});
  if (!in)
    return failed(edits.file_.string() + ": placements: expected to read them, found that it cannot be");
  const Json json = Json::parse(text, nullptr, false);
  if (!json.is_object() || json.value("type", Json()) != "FeatureCollection" || !json.contains("features") ||
      !json["features"].is_array())
    return bad_placements(edits.file_, "file", "a GeoJSON FeatureCollection", "something else");
  std::size_t number = 0;
  for (const Json& feature : json["features"]) {
    Result<Placement> placement = placement_of(edits.file_, "feature " + std::to_string(number++), feature);
    if (!placement) return placement.error();
    edits.placements_.push_back(std::move(*placement));
  }
  return edits;
}

Status ObjectEdits::save(std::span<const Placement> placements) const {
  Json json{{"type", "FeatureCollection"}, {"features", Json::array()}};
  for (const Placement& placement : placements) json["features"].push_back(feature_of(placement));
  const std::string text = json.dump(1) + "\n";
  std::filesystem::path part = file_;
  part += ".part";
  Result<File> out = File::open_to_write(part);
  if (!out) return out.error();
  if (const Status cut = out->truncate(0); !cut) return cut;
  if (const Status written = out->write(0, std::as_bytes(std::span(text))); !written) return written;
  if (const Status synced = out->sync(); !synced) return synced;
  return rename_durably(part, file_);
}

Status ObjectEdits::become(std::vector<Placement> next) {
  if (const Status saved = save(next); !saved) return saved;
  before_.push_back(std::exchange(placements_, std::move(next)));
  return {};
}

Status ObjectEdits::place(Placement placement) {
  std::vector<Placement> next = placements_;
  next.push_back(std::move(placement));
  return become(std::move(next));
}

Status ObjectEdits::change(std::size_t index, Placement placement) {
  std::vector<Placement> next = placements_;
  next[index] = std::move(placement);
  return become(std::move(next));
}

Status ObjectEdits::remove(std::size_t index) {
  std::vector<Placement> next = placements_;
  next.erase(next.begin() + static_cast<std::ptrdiff_t>(index));
  return become(std::move(next));
}

Status ObjectEdits::undo() {
  if (before_.empty()) return {};
  if (const Status saved = save(before_.back()); !saved) return saved;
  placements_ = std::move(before_.back());
  before_.pop_back();
  return {};
}

std::optional<std::size_t> PlacedTiles::placement_of(const ObjectHit& hit) const {
  for (const Slot& slot : slots_) {
    if (slot.tile == hit.tile && slot.object == hit.object) return slot.placement;
  }
  return std::nullopt;
}

PlacedTiles placed_tiles(std::span<const Placement> placements,
                         std::span<const std::shared_ptr<const ObjectModel>> models, const Body& body) {
  PlacedTiles placed;
  std::map<std::string, std::uint16_t> numbers;
  for (std::size_t i = 0; i < models.size(); ++i)
    numbers.emplace(models[i]->name, static_cast<std::uint16_t>(i));
  std::map<TileId, ObjectTile> tiles;
  for (std::size_t i = 0; i < placements.size(); ++i) {
    const Placement& placement = placements[i];
    const auto number = numbers.find(placement.model);
    if (number == numbers.end()) {
      if (std::find(placed.unknown.begin(), placed.unknown.end(), placement.model) == placed.unknown.end())
        placed.unknown.push_back(placement.model);
      continue;
    }
    auto [tile, object] = tile_object({placement.at, placement.heading_deg, placement.scale,
                                       static_cast<double>(models[number->second]->size_m())},
                                      body);
    object.model = number->second;
    tiles[tile].objects.push_back(object);
    placed.slots_.push_back({tile, object, i});
  }
  for (const auto& [id, objects] : tiles) {
    std::vector<std::uint16_t> used;
    for (const PlacedObject& object : objects.objects) used.push_back(object.model);
    std::sort(used.begin(), used.end());
    used.erase(std::unique(used.begin(), used.end()), used.end());
    std::vector<std::shared_ptr<const ObjectModel>> own;
    for (const std::uint16_t number : used) own.push_back(models[number]);
    placed.tiles.push_back(std::make_shared<const LoadedObjects>(id, objects, used, std::move(own)));
  }
  return placed;
}

}  // namespace cairn::viewer
