#include "builder/objects/place_feature.h"

#include <charconv>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace cairn {
namespace {

using FeatureJson = nlohmann::json;

constexpr double kMostSeed = 9007199254740992.0;  // 2^53

std::string text_of(const FeatureJson& json) {
  return json.dump(-1, ' ', false, FeatureJson::error_handler_t::replace).substr(0, 60);
}

/// Numbers may be texts, which is all that some formats have.
Status read_number(const FeatureJson& properties, const char* key, double& value) {
  const auto found = properties.find(key);
  if (found == properties.end() || found->is_null()) return {};
  if (found->is_number()) return value = found->get<double>(), Status();
  if (found->is_string()) {
    const auto& text = found->get_ref<const std::string&>();
    if (text.empty()) return {};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc() && end == text.data() + text.size()) return {};
  }
  return bad_data(fmt::format("{}: expected a number, found {}", key, text_of(*found)));
}

Status read_word(const FeatureJson& properties, const char* key, std::string& word) {
  const auto found = properties.find(key);
  if (found == properties.end() || found->is_null()) return {};
  if (!found->is_string()) return bad_data(fmt::format("{}: expected text, found {}", key, text_of(*found)));
  if (!found->get_ref<const std::string&>().empty()) word = found->get<std::string>();
  return {};
}

struct NumberProperty {
  const char* key;
  double* value;
};
Status read_numbers(const FeatureJson& properties, std::initializer_list<NumberProperty> wanted) {
  for (const NumberProperty& number : wanted) {
    if (auto status = read_number(properties, number.key, *number.value); !status) return status;
  }
  return {};
}

Status read_place(const FeatureJson& properties, ObjectPlace& place) {
  std::string mode = "ground";
  if (auto status = read_word(properties, "model", place.model); !status) return status;
  if (auto status = read_word(properties, "mode", mode); !status) return status;
  const auto status = read_numbers(
      properties,
      {{"heading", &place.heading_degrees}, {"scale", &place.scale}, {"height", &place.height_m}});
  return status ? set_mode(mode, place) : status;
}

Status read_rule(const FeatureJson& properties, ScatterRule& rule) {
  std::string models;
  double seed = 0, heading = std::nan("");
  if (auto status = read_word(properties, "model", models); !status) return status;
  const auto status = read_numbers(properties, {{"density", &rule.per_hectare},
                                                {"spacing", &rule.spacing_m},
                                                {"seed", &seed},
                                                {"heading", &heading},
                                                {"min_scale", &rule.min_scale},
                                                {"max_scale", &rule.max_scale},
                                                {"min_slope", &rule.limits.min_slope_deg},
                                                {"max_slope", &rule.limits.max_slope_deg},
                                                {"min_height", &rule.limits.min_height_m},
                                                {"max_height", &rule.limits.max_height_m}});
  if (!status) return status;
  if (!(seed >= 0 && seed <= kMostSeed && seed == std::floor(seed)))
    return bad_data(fmt::format("seed: expected a whole number of 0 to 2^53, found {}", seed));
  rule.seed = static_cast<std::uint64_t>(seed);
  if (properties.contains("heading") && !std::isnan(heading)) rule.heading_degrees = heading;
  if (models.empty()) return bad_data("model: expected NAME[:WEIGHT],…, found none");
  return set_models(models, rule);
}

Status read_position(const FeatureJson& position, LonLat& at) {
  const bool good =
      position.is_array() && position.size() >= 2 && position[0].is_number() && position[1].is_number();
  if (!good)
    return bad_data(fmt::format("coordinates: expected numbers lon and lat, found {}", text_of(position)));
  at = {position[0].get<double>(), position[1].get<double>()};
  return {};
}

Status expect_array(const FeatureJson& coordinates) {
  if (coordinates.is_array()) return {};
  return bad_data(fmt::format("coordinates: expected an array, found {}", text_of(coordinates)));
}

Status read_points(const FeatureJson& properties, const FeatureJson& positions, const PlaceVisitor& visitor) {
  ObjectPlace place;
  if (auto status = read_place(properties, place); !status) return status;
  if (auto status = expect_array(positions); !status) return status;
  for (const FeatureJson& position : positions) {
    if (auto status = read_position(position, place.at); !status) return status;
    if (auto status = check_place(place); !status) return status;
    if (auto status = visitor.place(place); !status) return status;
  }
  return {};
}

Status add_rings(const FeatureJson& polygon, ScatterArea& area) {
  if (auto status = expect_array(polygon); !status) return status;
  for (const FeatureJson& ring : polygon) {
    if (auto status = expect_array(ring); !status) return status;
    auto& places = area.rings.emplace_back();
    for (const FeatureJson& position : ring) {
      if (auto status = read_position(position, places.emplace_back()); !status) return status;
    }
  }
  return {};
}

Status read_area(const FeatureJson& properties, const FeatureJson& polygons, const PlaceVisitor& visitor) {
  ScatterArea area;
  if (auto status = read_rule(properties, area.rule); !status) return status;
  if (auto status = expect_array(polygons); !status) return status;
  for (const FeatureJson& polygon : polygons) {
    if (auto status = add_rings(polygon, area); !status) return status;
  }
  if (auto status = check_area(area); !status) return status;
  return visitor.area(area);
}

}  // namespace

Status read_feature(const FeatureJson& feature, const PlaceVisitor& visitor) {
  static const FeatureJson none;
  const auto member = [](const FeatureJson& of, const char* key) -> const FeatureJson& {
    return of.is_object() && of.contains(key) ? of.at(key) : none;
  };
  const FeatureJson& geometry = member(feature, "geometry");
  const FeatureJson& type = member(geometry, "type");
  const FeatureJson& coordinates = member(geometry, "coordinates");
  const FeatureJson& properties = member(feature, "properties");
  const bool is_point = type == "Point" || type == "MultiPoint";
  if (!is_point && type != "Polygon" && type != "MultiPolygon")
    return bad_data(fmt::format("geometry: expected a Point, MultiPoint, Polygon or MultiPolygon, found {}",
                                text_of(type)));
  if (!properties.is_object())
    return bad_data(fmt::format("properties: expected an object, found {}", text_of(properties)));
  const bool is_one = type == "Point" || type == "Polygon";
  const FeatureJson parts = is_one ? FeatureJson::array({coordinates}) : coordinates;
  return is_point ? read_points(properties, parts, visitor) : read_area(properties, parts, visitor);
}

}  // namespace cairn
