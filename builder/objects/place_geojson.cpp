#include <algorithm>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/objects/place_files.h"

namespace cairn {
namespace {

using SortedJson = nlohmann::json;

std::string text_of(const SortedJson& json) {
  return json.dump(-1, ' ', false, SortedJson::error_handler_t::replace).substr(0, 60);
}

Status read_number(const SortedJson& properties, const char* key, double& value) {
  const auto found = properties.find(key);
  if (found == properties.end() || found->is_null()) return {};
  if (!found->is_number())
    return bad_data(fmt::format("{}: expected a number, found {}", key, text_of(*found)));
  value = found->get<double>();
  return {};
}

Status read_word(const SortedJson& properties, const char* key, std::string& word) {
  const auto found = properties.find(key);
  if (found == properties.end() || found->is_null()) return {};
  if (!found->is_string()) return bad_data(fmt::format("{}: expected text, found {}", key, text_of(*found)));
  word = found->get<std::string>();
  return {};
}

Status read_properties(const SortedJson& properties, ObjectPlace& place) {
  if (!properties.is_object())
    return bad_data(fmt::format("properties: expected an object, found {}", text_of(properties)));
  std::string mode = "ground";
  if (auto status = read_word(properties, "model", place.model); !status) return status;
  if (auto status = read_word(properties, "mode", mode); !status) return status;
  for (const auto& [key, value] :
       {std::pair{"heading", &place.heading_degrees}, {"scale", &place.scale}, {"height", &place.height_m}}) {
    if (auto status = read_number(properties, key, *value); !status) return status;
  }
  return set_mode(mode, place);
}

Status read_position(const SortedJson& position, LonLat& at) {
  const bool good =
      position.is_array() && position.size() >= 2 && position[0].is_number() && position[1].is_number();
  if (!good)
    return bad_data(fmt::format("coordinates: expected numbers lon and lat, found {}", text_of(position)));
  at = {position[0].get<double>(), position[1].get<double>()};
  return {};
}

Status read_feature(const SortedJson& feature, const TakePlace& take) {
  const auto member = [&feature](const char* key) {
    return feature.is_object() && feature.contains(key) ? feature.at(key) : SortedJson();
  };
  const SortedJson geometry = member("geometry");
  const SortedJson type =
      geometry.is_object() && geometry.contains("type") ? geometry.at("type") : SortedJson();
  if (type != "Point" && type != "MultiPoint")
    return bad_data(fmt::format("geometry: expected a Point or a MultiPoint, found {}", text_of(type)));
  const SortedJson coordinates = geometry.contains("coordinates") ? geometry.at("coordinates") : SortedJson();
  ObjectPlace place;
  if (auto status = read_properties(member("properties"), place); !status) return status;
  const SortedJson positions = type == "Point" ? SortedJson::array({coordinates}) : coordinates;
  if (!positions.is_array())
    return bad_data(fmt::format("coordinates: expected an array, found {}", text_of(coordinates)));
  for (const SortedJson& position : positions) {
    if (auto status = read_position(position, place.at); !status) return status;
    if (auto status = check_place(place); !status) return status;
    if (auto status = take(place); !status) return status;
  }
  return {};
}

}  // namespace

Status read_places_geojson(const std::filesystem::path& file, const TakePlace& take) {
  std::ifstream in(file, std::ios::binary);
  if (!in) return failed(file.string() + ": expected a file that can be read, found none");
  const SortedJson json = SortedJson::parse(in, nullptr, false);
  const SortedJson type = json.is_object() && json.contains("type") ? json.at("type") : SortedJson();
  SortedJson features = SortedJson::array();
  if (type == "Feature") features.push_back(json);
  if (type == "FeatureCollection" && json.contains("features")) features = json.at("features");
  if (!features.is_array() || features.empty())
    return bad_data(file.string() + ": expected a FeatureCollection of GeoJSON with features, found " +
                    (json.is_discarded() ? "no JSON" : "none"));
  for (std::size_t i = 0; i < features.size(); ++i) {
    if (auto status = read_feature(features[i], take); !status)
      return Error{status.error().code,
                   fmt::format("{}: feature {}: {}", file.string(), i, status.error().message)};
  }
  return {};
}

}  // namespace cairn
