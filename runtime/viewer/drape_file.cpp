#include "runtime/viewer/drape_file.h"

#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>
#include <pugixml.hpp>

#include "runtime/gl/srgb.h"

namespace cairn::viewer {
namespace {

using nlohmann::json;

constexpr float kPoint = 2.5f;          // a point is as many times as wide as a line
constexpr double kWidest_px = 100;      // of a line
constexpr int kDeepestCollection = 16;  // of geometries within geometries

/// "#RRGGBB" or "#RGB", also without the number sign, as simplestyle has it.
std::optional<std::uint32_t> colour_of(std::string_view text) {
  if (!text.empty() && text.front() == '#') text.remove_prefix(1);
  if (text.size() != 3 && text.size() != 6) return std::nullopt;
  std::uint32_t value = 0;
  for (const char c : text) {
    const std::size_t digit = std::string_view("0123456789abcdef")
                                  .find(static_cast<char>(c >= 'A' && c <= 'F' ? c - 'A' + 'a' : c));
    if (digit == std::string_view::npos) return std::nullopt;
    for (std::size_t twice = text.size() == 3 ? 2 : 1; twice > 0; --twice) {
      value = value << 4 | static_cast<std::uint32_t>(digit);
    }
  }
  return value;
}

struct Style {
  glm::vec3 colour{1};
  float width_px = 3;
};

Error wrong(const std::string& where, const std::string& expected, const std::string& found) {
  return bad_data(where + ": expected " + expected + ", found " + found);
}

std::string shown(const json& value) {
  std::string text = value.dump(-1, ' ', true, json::error_handler_t::replace);
  if (text.size() > 60) text = text.substr(0, 57) + "...";
  return text;
}

/// The geometries of one GeoJSON file.
class GeoJson {
 public:
  GeoJson(std::string file, Style style, Drape& drape)
      : file_(std::move(file)), style_(style), drape_(drape) {}

  Status read(const json& root) {
    if (!root.is_object()) return wrong(file_ + ": GeoJSON", "an object", shown(root));
    const std::string type = root.value("type", json()).is_string() ? root.at("type") : json("nothing");
    if (type == "FeatureCollection") {
      const json features = root.value("features", json());
      if (!features.is_array()) return wrong(file_ + ": features", "an array", shown(features));
      for (std::size_t i = 0; i < features.size(); ++i) {
        if (const Status read = feature(features[i], "features[" + std::to_string(i) + "]"); !read)
          return read;
      }
      return {};
    }
    return type == "Feature" ? feature(root, "feature") : geometry(root, "geometry", style_, 0);
  }

 private:
  Status feature(const json& value, const std::string& where) {
    if (!value.is_object()) return wrong(file_ + ": " + where, "a feature", shown(value));
    Style style = style_;
    const json properties = value.value("properties", json());
    if (properties.is_object()) {
      for (const char* key : {"marker-color", "stroke"}) {
        const json text = properties.value(key, json());
        if (!text.is_string()) continue;
        const auto colour = colour_of(text.get<std::string>());
        if (!colour) return wrong(file_ + ": " + where + "." + key, "#RRGGBB", shown(text));
        style.colour = gl::linear_of(*colour);
      }
      const json width = properties.value("stroke-width", json());
      if (width.is_number()) {
        if (!(width.get<double>() > 0 && width.get<double>() <= kWidest_px)) {
          return wrong(file_ + ": " + where + ".stroke-width", "more than 0 and up to 100", shown(width));
        }
        style.width_px = width.get<float>();
      }
    }
    const json shape = value.value("geometry", json());
    return shape.is_null() ? Status{} : geometry(shape, where + ".geometry", style, 0);
  }

  Status geometry(const json& value, const std::string& where, const Style& style, int depth) {
    const std::string place = file_ + ": " + where;
    if (!value.is_object()) return wrong(place, "a geometry", shown(value));
    const json type = value.value("type", json());
    if (type == "GeometryCollection") {
      const json members = value.value("geometries", json());
      if (!members.is_array() || depth > kDeepestCollection) {
        return wrong(place + ".geometries", "an array of geometries", shown(members));
      }
      for (std::size_t i = 0; i < members.size(); ++i) {
        const std::string member = where + ".geometries[" + std::to_string(i) + "]";
        if (const Status read = geometry(members[i], member, style, depth + 1); !read) return read;
      }
      return {};
    }
    // How many arrays are around a line.
    constexpr std::array<std::pair<std::string_view, int>, 6> kTypes = {{{"Point", -1},
                                                                         {"MultiPoint", -2},
                                                                         {"LineString", 0},
                                                                         {"MultiLineString", 1},
                                                                         {"Polygon", 1},
                                                                         {"MultiPolygon", 2}}};
    for (const auto& [name, around] : kTypes) {
      if (type != name) continue;
      const json coordinates = value.value("coordinates", json());
      return around < 0 ? points(coordinates, place + ".coordinates", style, -around - 1)
                        : lines(coordinates, place + ".coordinates", style, around);
    }
    return wrong(place + ".type", "a type of GeoJSON", shown(type));
  }

  Status points(const json& value, const std::string& where, const Style& style, int around) {
    if (around == 0) {
      const Result<LonLat> at = place(value, where);
      if (!at) return at.error();
      drape_.lines.push_back({{*at}, style.colour, style.width_px * kPoint});
      return {};
    }
    return each(value, where, [&](const json& member, const std::string& name) {
      return points(member, name, style, around - 1);
    });
  }

  Status lines(const json& value, const std::string& where, const Style& style, int around) {
    if (around > 0) {
      return each(value, where, [&](const json& member, const std::string& name) {
        return lines(member, name, style, around - 1);
      });
    }
    DrapedLine line{{}, style.colour, style.width_px};
    const Status read = each(value, where, [&](const json& member, const std::string& name) -> Status {
      const Result<LonLat> at = place(member, name);
      if (!at) return at.error();
      line.places.push_back(*at);
      return {};
    });
    if (!read) return read;
    if (line.places.size() < 2) return wrong(where, "two places or more", shown(value));
    drape_.lines.push_back(std::move(line));
    return {};
  }

  template <class Visit>
  Status each(const json& value, const std::string& where, const Visit& visit) {
    if (!value.is_array()) return wrong(where, "an array", shown(value));
    for (std::size_t i = 0; i < value.size(); ++i) {
      if (const Status read = visit(value[i], where + "[" + std::to_string(i) + "]"); !read) return read;
    }
    return {};
  }

  Result<LonLat> place(const json& value, const std::string& where) {
    const bool is_pair =
        value.is_array() && value.size() >= 2 && value[0].is_number() && value[1].is_number();
    const LonLat at = is_pair ? LonLat{value[0], value[1]} : LonLat{1e9, 0};
    if (!(std::abs(at.lon) <= 540 && std::abs(at.lat) <= 90)) {
      return wrong(where, "longitude and latitude in degrees", shown(value));
    }
    return at;
  }

  std::string file_;
  Style style_;
  Drape& drape_;
};

/// The tracks, routes and waypoints of one GPX file.
class Gpx {
 public:
  Gpx(std::string file, Style style, Drape& drape) : file_(std::move(file)), style_(style), drape_(drape) {}

  Status read(const pugi::xml_document& document) {
    const pugi::xml_node root = document.child("gpx");
    if (!root) return wrong(file_ + ": GPX", "the element gpx", document.first_child().name());
    for (const pugi::xml_node point : root.children("wpt")) {
      const Result<LonLat> at = place(point);
      if (!at) return at.error();
      drape_.lines.push_back({{*at}, style_.colour, style_.width_px * kPoint});
    }
    for (const pugi::xml_node route : root.children("rte")) {
      if (const Status read = line(route, "rtept"); !read) return read;
    }
    for (const pugi::xml_node track : root.children("trk")) {
      for (const pugi::xml_node part : track.children("trkseg")) {
        if (const Status read = line(part, "trkpt"); !read) return read;
      }
    }
    return {};
  }

 private:
  Status line(const pugi::xml_node& node, const char* name) {
    DrapedLine line{{}, style_.colour, style_.width_px};
    for (const pugi::xml_node point : node.children(name)) {
      const Result<LonLat> at = place(point);
      if (!at) return at.error();
      line.places.push_back(*at);
    }
    if (!line.places.empty()) drape_.lines.push_back(std::move(line));
    return {};
  }

  Result<LonLat> place(const pugi::xml_node& point) {
    const LonLat at{number(point.attribute("lon").value()), number(point.attribute("lat").value())};
    if (std::abs(at.lon) <= 540 && std::abs(at.lat) <= 90) return at;
    return wrong(file_ + ": " + point.name() + " at byte " + std::to_string(point.offset_debug()),
                 "lon and lat in degrees",
                 "lon=\"" + std::string(point.attribute("lon").value()) + "\" lat=\"" +
                     point.attribute("lat").value() + "\"");
  }

  /// Infinite where the text is no number.
  static double number(std::string_view text) {
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    const bool is_whole = error == std::errc() && end == text.data() + text.size();
    return is_whole ? value : std::numeric_limits<double>::infinity();
  }

  std::string file_;
  Style style_;
  Drape& drape_;
};

/// Colours that stand out from ground, and from each other.
Style style_of_file(std::size_t number) {
  constexpr std::array<std::uint32_t, 4> kColours = {0xFF2D20, 0xFFD400, 0x00C8FF, 0xFF4FD8};
  return {gl::linear_of(kColours[number % kColours.size()]), 3};
}

Status read_file(const std::filesystem::path& path, const Style& style, Drape& drape) {
  std::ifstream in(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  if (!in) return failed(path.string() + ": read: expected a file that can be read, found none");
  const std::size_t first = text.find_first_not_of("\xEF\xBB\xBF \t\r\n");
  if (first != std::string::npos && text[first] == '<') {
    pugi::xml_document document;
    const pugi::xml_parse_result parsed = document.load_buffer(text.data(), text.size());
    if (!parsed) {
      return wrong(path.string() + ": byte " + std::to_string(parsed.offset), "XML", parsed.description());
    }
    return Gpx(path.string(), style, drape).read(document);
  }
  const json root = json::parse(text.begin(), text.end(), nullptr, false);
  if (root.is_discarded()) return wrong(path.string() + ": text", "GeoJSON or GPX", "neither");
  return GeoJson(path.string(), style, drape).read(root);
}

}  // namespace

Result<Drape> read_drapes(const std::vector<std::filesystem::path>& files) {
  Drape drape;
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (const Status read = read_file(files[i], style_of_file(i), drape); !read) return read.error();
  }
  return drape;
}

}  // namespace cairn::viewer
