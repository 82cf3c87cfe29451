#include "builder/pack/options_json.h"

#include <array>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

namespace cairn {
namespace {

using Json = nlohmann::ordered_json;

// The words for the values of an enum; the first value is not necessarily the default.
template <class Enum>
struct Words;

template <>
struct Words<ResampleMethod> {
  static constexpr std::array<std::pair<ResampleMethod, const char*>, 5> all{
      {{ResampleMethod::nearest, "nearest"},
       {ResampleMethod::bilinear, "bilinear"},
       {ResampleMethod::cubic, "cubic"},
       {ResampleMethod::exact, "exact"},
       {ResampleMethod::smooth, "smooth"}}};
};

template <>
struct Words<VoidMode> {
  static constexpr std::array<std::pair<VoidMode, const char*>, 2> all{
      {{VoidMode::fill, "fill"}, {VoidMode::keep, "keep"}}};
};

template <>
struct Words<VerticalDatum> {
  static constexpr std::array<std::pair<VerticalDatum, const char*>, 3> all{
      {{VerticalDatum::unknown, "unknown"},
       {VerticalDatum::egm96, "egm96"},
       {VerticalDatum::ellipsoid, "ellipsoid"}}};
};

template <>
struct Words<LatitudeKind> {
  static constexpr std::array<std::pair<LatitudeKind, const char*>, 2> all{
      {{LatitudeKind::planetographic, "planetographic"}, {LatitudeKind::planetocentric, "planetocentric"}}};
};

template <>
struct Words<LongitudeSense> {
  static constexpr std::array<std::pair<LongitudeSense, const char*>, 2> all{
      {{LongitudeSense::east, "east"}, {LongitudeSense::west, "west"}}};
};

template <>
struct Words<TextureFormat> {
  static constexpr std::array<std::pair<TextureFormat, const char*>, 3> all{
      {{TextureFormat::bc1, "bc1"}, {TextureFormat::bc3, "bc3"}, {TextureFormat::bc7, "bc7"}}};
};

template <>
struct Words<TextureQuality> {
  static constexpr std::array<std::pair<TextureQuality, const char*>, 3> all{
      {{TextureQuality::fast, "fast"}, {TextureQuality::normal, "normal"}, {TextureQuality::best, "best"}}};
};

template <class Enum>
const char* word_for(Enum value) {
  for (const auto& [known, word] : Words<Enum>::all) {
    if (known == value) return word;
  }
  return "";
}

Json json_of(const GeoBounds& b) {
  return {{"west", b.west}, {"south", b.south}, {"east", b.east}, {"north", b.north}};
}

template <class T>
void write(Json& json, const char* key, const std::optional<T>& value) {
  if (!value) return;
  if constexpr (std::is_same_v<T, GeoBounds>) {
    json[key] = json_of(*value);
  } else if constexpr (std::is_enum_v<T>) {
    json[key] = word_for(*value);
  } else {
    json[key] = *value;
  }
}

// Reads members of a JSON object into options; the first that is wrong is the error.
class OptionReader {
 public:
  explicit OptionReader(const nlohmann::json& json) : json_(json) {}

  template <class T>
  void read(const char* key, T& value) {
    const nlohmann::json* member = find(key);
    if (member == nullptr) return;
    if constexpr (std::is_same_v<T, GeoBounds>) {
      OptionReader bounds(*member);
      bounds.read("west", value.west);
      bounds.read("south", value.south);
      bounds.read("east", value.east);
      bounds.read("north", value.north);
      if (!bounds.status_) status_ = bounds.status_;
    } else if constexpr (std::is_enum_v<T>) {
      read_word(key, *member, value);
    } else if constexpr (std::is_same_v<T, std::string>) {
      member->is_string() ? void(value = member->template get<std::string>()) : expect(key, "text", *member);
    } else if constexpr (std::is_same_v<T, int>) {
      member->is_number_integer() ? void(value = member->template get<int>())
                                  : expect(key, "a whole number", *member);
    } else {
      member->is_number() ? void(value = member->template get<T>()) : expect(key, "a number", *member);
    }
  }

  template <class T>
  void read(const char* key, std::optional<T>& value) {
    if (find(key) != nullptr) read(key, value.emplace());
  }

  const nlohmann::json* find(const char* key) const {
    const auto member = json_.find(key);
    return member == json_.end() ? nullptr : &*member;
  }

  const Status& status() const { return status_; }

 private:
  template <class Enum>
  void read_word(const char* key, const nlohmann::json& member, Enum& value) {
    std::string words;
    for (const auto& [known, word] : Words<Enum>::all) {
      if (member == word) {
        value = known;
        return;
      }
      words += std::string(words.empty() ? "" : ", ") + word;
    }
    expect(key, "one of " + words, member);
  }

  void expect(const std::string& key, const std::string& expected, const nlohmann::json& found) {
    if (!status_.ok()) return;
    const std::string text = found.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
    status_ = bad_data("options: " + key + ": expected " + expected + ", found " + text);
  }

  const nlohmann::json& json_;
  Status status_;
};

void write_source_rules(Json& json, const std::vector<SourceRule>& rules) {
  for (const SourceRule& rule : rules) {
    Json said = to_json(rule.overrides);
    said["pattern"] = rule.glob;
    json["sources"].push_back(said);
  }
}

Json json_of(const ImageryOptions& o) {
  const auto& [inputs, source_rules, bounds, format, quality, feather_pixels] = o;
  Json json{{"format", word_for(format)}, {"quality", word_for(quality)}, {"feather_pixels", feather_pixels}};
  write(json, "bounds", bounds);
  write_source_rules(json, source_rules);
  return json;
}

Status read_source_rules(const OptionReader& reader, std::vector<SourceRule>& rules) {
  const nlohmann::json* sources = reader.find("sources");
  if (sources == nullptr) return {};
  if (!sources->is_array()) return bad_data("options: sources: expected an array, found another type");
  for (const nlohmann::json& source : *sources) {
    if (!source.is_object()) return bad_data("options: sources: expected objects, found another type");
    OptionReader said(source);
    SourceRule& rule = rules.emplace_back();
    said.read("pattern", rule.glob);
    said.read("band", rule.overrides.band);
    said.read("nodata", rule.overrides.nodata);
    said.read("scale", rule.overrides.scale);
    said.read("offset", rule.overrides.offset);
    said.read("unit", rule.overrides.unit);
    said.read("crs", rule.overrides.crs);
    said.read("body", rule.overrides.body);
    said.read("latitude", rule.overrides.latitude);
    said.read("longitude", rule.overrides.longitude);
    said.read("sea_clamp_m", rule.overrides.sea_clamp_m);
    said.read("black", rule.overrides.black);
    said.read("white", rule.overrides.white);
    said.read("priority", rule.overrides.priority);
    if (!said.status()) return said.status();
  }
  return {};
}

}  // namespace

nlohmann::ordered_json to_json(const SourceOverrides& said) {
  const auto& [band, nodata, scale, offset, unit, crs, body, latitude, longitude, sea_clamp_m, black, white,
               priority] = said;
  Json json = Json::object();
  write(json, "band", band);
  write(json, "nodata", nodata);
  write(json, "scale", scale);
  write(json, "offset", offset);
  write(json, "unit", unit);
  write(json, "crs", crs);
  write(json, "body", body);
  write(json, "latitude", latitude);
  write(json, "longitude", longitude);
  write(json, "sea_clamp_m", sea_clamp_m);
  write(json, "black", black);
  write(json, "white", white);
  write(json, "priority", priority);
  return json;
}

// The structures are taken apart so that a member which is added to one stops the compilation here.
nlohmann::ordered_json to_json(const BuildOptions& options) {
  const auto& [grid, mosaic, heights, imagery, objects, session] = options;
  const auto& [tile_size, top, region] = grid;
  const auto& [dems, level, max_error_m, resampling, datum, geoid, source_rules, fade_posts, void_posts] =
      mosaic;
  const auto& [quantum_m, allow_error, voids, rqt_tolerance_m] = heights;
  Json json{{"tile_size", tile_size},
            {"resampling", word_for(resampling)},
            {"void", word_for(voids)},
            {"fade", fade_posts}};
  write(json, "void_distance", void_posts);
  write(json, "datum", datum);
  write_source_rules(json, source_rules);
  write(json, "level", level);
  write(json, "top", top);
  write(json, "region", region);
  write(json, "max_error", max_error_m);
  write(json, "quantum", quantum_m);
  write(json, "rqt", rqt_tolerance_m);
  if (geoid) json["geoid"] = true;
  if (!imagery.inputs.empty()) json["imagery"] = json_of(imagery);
  if (!objects.places.empty()) json["objects"] = true;
  return json;
}

Result<BuildOptions> from_json(const nlohmann::json& json) {
  if (!json.is_object()) return bad_data("options: expected an object, found another type");
  BuildOptions options;
  OptionReader reader(json);
  reader.read("tile_size", options.grid.tile_size);
  reader.read("top", options.grid.top);
  reader.read("region", options.grid.region);
  reader.read("level", options.mosaic.level);
  reader.read("max_error", options.mosaic.max_error_m);
  reader.read("resampling", options.mosaic.resampling);
  reader.read("datum", options.mosaic.datum);
  reader.read("fade", options.mosaic.fade_posts);
  reader.read("void_distance", options.mosaic.void_posts);
  if (auto rules = read_source_rules(reader, options.mosaic.source_rules); !rules) return rules.error();
  reader.read("quantum", options.heights.quantum_m);
  reader.read("void", options.heights.voids);
  reader.read("rqt", options.heights.rqt_tolerance_m);
  if (!reader.status()) return reader.status().error();
  const nlohmann::json* imagery = reader.find("imagery");
  if (imagery == nullptr) return options;
  if (!imagery->is_object()) return bad_data("options: imagery: expected an object, found another type");
  OptionReader images(*imagery);
  if (auto rules = read_source_rules(images, options.imagery.source_rules); !rules) return rules.error();
  images.read("bounds", options.imagery.bounds);
  images.read("format", options.imagery.format);
  images.read("quality", options.imagery.quality);
  images.read("feather_pixels", options.imagery.feather_pixels);
  if (!images.status()) return images.status().error();
  return options;
}

}  // namespace cairn
