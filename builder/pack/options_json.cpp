#include "builder/pack/options_json.h"

#include <array>
#include <concepts>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

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

// The members of each structure in JSON, in their order; OptionWriter and OptionReader go through them. The
// structures are taken apart so that a member which is added to one stops the compilation here.
template <class T, class Plain>
concept MaybeConst = std::same_as<std::remove_const_t<T>, Plain>;

template <class Visitor, MaybeConst<GeoBounds> Bounds>
void visit_members(Visitor& visitor, Bounds& bounds) {
  auto& [west, south, east, north] = bounds;
  visitor.member("west", west);
  visitor.member("south", south);
  visitor.member("east", east);
  visitor.member("north", north);
}

template <class Visitor, MaybeConst<SourceOverrides> Overrides>
void visit_members(Visitor& visitor, Overrides& said) {
  auto& [band, nodata, scale, offset, unit, crs, body, latitude, longitude, sea_clamp_m, black, white,
         priority] = said;
  visitor.member("band", band);
  visitor.member("nodata", nodata);
  visitor.member("scale", scale);
  visitor.member("offset", offset);
  visitor.member("unit", unit);
  visitor.member("crs", crs);
  visitor.member("body", body);
  visitor.member("latitude", latitude);
  visitor.member("longitude", longitude);
  visitor.member("sea_clamp_m", sea_clamp_m);
  visitor.member("black", black);
  visitor.member("white", white);
  visitor.member("priority", priority);
}

template <class Visitor, MaybeConst<SourceRule> Rule>
void visit_members(Visitor& visitor, Rule& rule) {
  auto& [glob, overrides] = rule;
  visit_members(visitor, overrides);
  visitor.member("pattern", glob);
}

template <class Visitor, MaybeConst<ImageryOptions> Options>
void visit_members(Visitor& visitor, Options& options) {
  auto& [inputs, source_rules, bounds, format, quality, feather_pixels] = options;
  visitor.member("format", format);
  visitor.member("quality", quality);
  visitor.member("feather_pixels", feather_pixels);
  visitor.member("bounds", bounds);
  visitor.member("sources", source_rules);
}

template <class Visitor, MaybeConst<BuildOptions> Options>
void visit_members(Visitor& visitor, Options& options) {
  auto& [grid, mosaic, heights, imagery, objects, session] = options;
  auto& [tile_size, top, region] = grid;
  auto& [dems, level, max_error_m, resampling, datum, geoid, source_rules, fade_posts, void_posts] = mosaic;
  auto& [quantum_m, allow_error, voids, rqt_tolerance_m] = heights;
  visitor.member("tile_size", tile_size);
  visitor.member("resampling", resampling);
  visitor.member("void", voids);
  visitor.member("fade", fade_posts);
  visitor.member("void_distance", void_posts);
  visitor.member("datum", datum);
  visitor.member("sources", source_rules);
  visitor.member("level", level);
  visitor.member("top", top);
  visitor.member("region", region);
  visitor.member("max_error", max_error_m);
  visitor.member("quantum", quantum_m);
  visitor.member("rqt", rqt_tolerance_m);
  visitor.presence("geoid", geoid.has_value());
  visitor.member("imagery", imagery);
  visitor.presence("objects", !objects.places.empty());
}

// Writes options as members of a JSON object; an optional that is empty writes none.
class OptionWriter {
 public:
  template <class T>
  void member(const char* key, const T& value) {
    if constexpr (std::is_same_v<T, GeoBounds>) {
      OptionWriter bounds;
      visit_members(bounds, value);
      json[key] = bounds.json;
    } else if constexpr (std::is_enum_v<T>) {
      json[key] = word_for(value);
    } else {
      json[key] = value;
    }
  }

  template <class T>
  void member(const char* key, const std::optional<T>& value) {
    if (value) member(key, *value);
  }

  void member(const char* key, const std::vector<SourceRule>& rules) {
    for (const SourceRule& rule : rules) {
      OptionWriter said;
      visit_members(said, rule);
      json[key].push_back(said.json);
    }
  }

  void member(const char* key, const ImageryOptions& imagery) {
    if (imagery.inputs.empty()) return;
    OptionWriter images;
    visit_members(images, imagery);
    json[key] = images.json;
  }

  /// Writes of files only that there are any.
  void presence(const char* key, bool is_given) {
    if (is_given) json[key] = true;
  }

  Json json = Json::object();
};

// Reads members of a JSON object into options; the first that is wrong is the error. What the object lacks
// stays as it is.
class OptionReader {
 public:
  explicit OptionReader(const nlohmann::json& json) : json_(json) {}

  template <class T>
  void member(const char* key, T& value) {
    const nlohmann::json* found = find(key);
    if (found == nullptr) return;
    if constexpr (std::is_same_v<T, GeoBounds>) {
      read_object(*found, value);
    } else if constexpr (std::is_enum_v<T>) {
      read_word(key, *found, value);
    } else if constexpr (std::is_same_v<T, std::string>) {
      found->is_string() ? void(value = found->template get<std::string>()) : expect(key, "text", *found);
    } else if constexpr (std::is_same_v<T, int>) {
      found->is_number_integer() ? void(value = found->template get<int>())
                                 : expect(key, "a whole number", *found);
    } else {
      found->is_number() ? void(value = found->template get<T>()) : expect(key, "a number", *found);
    }
  }

  template <class T>
  void member(const char* key, std::optional<T>& value) {
    if (find(key) != nullptr) member(key, value.emplace());
  }

  void member(const char* key, std::vector<SourceRule>& rules) {
    const nlohmann::json* sources = find(key);
    if (sources == nullptr) return;
    if (!sources->is_array()) return fail(key, "expected an array, found another type");
    for (const nlohmann::json& source : *sources) {
      if (!source.is_object()) return fail(key, "expected objects, found another type");
      read_object(source, rules.emplace_back());
    }
  }

  void member(const char* key, ImageryOptions& imagery) {
    const nlohmann::json* found = find(key);
    if (found == nullptr) return;
    if (!found->is_object()) return fail(key, "expected an object, found another type");
    read_object(*found, imagery);
  }

  void presence(const char*, bool) {}

  const Status& status() const { return status_; }

 private:
  const nlohmann::json* find(const char* key) const {
    const auto member = json_.find(key);
    return member == json_.end() ? nullptr : &*member;
  }

  template <class T>
  void read_object(const nlohmann::json& json, T& value) {
    OptionReader members(json);
    visit_members(members, value);
    if (status_.ok()) status_ = members.status_;
  }

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
    fail(key, "expected " + expected + ", found " +
                  found.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }

  void fail(const std::string& key, const std::string& what) {
    if (status_.ok()) status_ = bad_data("options: " + key + ": " + what);
  }

  const nlohmann::json& json_;
  Status status_;
};

}  // namespace

nlohmann::ordered_json to_json(const SourceOverrides& said) {
  OptionWriter writer;
  visit_members(writer, said);
  return writer.json;
}

nlohmann::ordered_json to_json(const BuildOptions& options) {
  OptionWriter writer;
  visit_members(writer, options);
  return writer.json;
}

Result<BuildOptions> from_json(const nlohmann::json& json) {
  if (!json.is_object()) return bad_data("options: expected an object, found another type");
  BuildOptions options;
  OptionReader reader(json);
  visit_members(reader, options);
  if (!reader.status()) return reader.status().error();
  return options;
}

}  // namespace cairn
