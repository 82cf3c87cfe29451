#include "builder/raster/raster_info_json.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>

#include <nlohmann/json.hpp>

namespace cairn {
namespace {

using SortedJson = nlohmann::json;

// JSON has no NaN and no infinity.
SortedJson json_of(double value) {
  if (std::isfinite(value)) return value;
  return std::to_string(std::bit_cast<std::uint64_t>(value));
}

double number_from(const SortedJson& json) {
  if (json.is_number()) return json.get<double>();
  return std::bit_cast<double>(static_cast<std::uint64_t>(std::stoull(json.get<std::string>())));
}

SortedJson json_of(const Georeference& g) {
  SortedJson json{{"crs", static_cast<int>(g.crs)},
                  {"x0", json_of(g.x0)},
                  {"y0", json_of(g.y0)},
                  {"dx", json_of(g.dx)},
                  {"dy", json_of(g.dy)},
                  {"x_per_row", json_of(g.x_per_row)},
                  {"y_per_column", json_of(g.y_per_column)}};
  if (g.crs == Georeference::Crs::utm) {
    json["zone"] = g.utm_zone;
    json["north"] = g.utm_north;
  }
  if (g.latitude_factor != 1) json["latitude_factor"] = json_of(g.latitude_factor);
  if (!g.definition.empty()) json["definition"] = g.definition;
  if (g.transform) json["operation"] = g.transform->operation();
  return json;
}

Georeference georeference_from(const SortedJson& json) {
  Georeference g;
  g.crs = static_cast<Georeference::Crs>(json.at("crs").get<int>());
  g.utm_zone = json.value("zone", g.utm_zone);
  g.utm_north = json.value("north", g.utm_north);
  g.x0 = number_from(json.at("x0"));
  g.y0 = number_from(json.at("y0"));
  g.dx = number_from(json.at("dx"));
  g.dy = number_from(json.at("dy"));
  g.x_per_row = number_from(json.at("x_per_row"));
  g.y_per_column = number_from(json.at("y_per_column"));
  if (json.contains("latitude_factor")) g.latitude_factor = number_from(json.at("latitude_factor"));
  g.definition = json.value("definition", "");
  return g;
}

RasterInfo described(const SortedJson& json) {
  RasterInfo info;
  info.path = json.at("path").get<std::string>();
  info.format = json.at("format").get<std::string>();
  info.columns = json.at("columns").get<std::int64_t>();
  info.rows = json.at("rows").get<std::int64_t>();
  info.bands = json.at("bands").get<int>();
  info.type = static_cast<SampleType>(json.at("type").get<int>());
  info.whole_metres = json.at("whole_metres").get<bool>();
  info.georeference = georeference_from(json.at("georeference"));
  const SortedJson& body = json.at("body");
  info.body = {body.at(0).get<std::string>(), {number_from(body.at(1)), number_from(body.at(2))}};
  const SortedJson& bounds = json.at("bounds");
  info.bounds = {number_from(bounds.at(0)), number_from(bounds.at(1)), number_from(bounds.at(2)),
                 number_from(bounds.at(3))};
  if (json.contains("nodata")) info.nodata = number_from(json.at("nodata"));
  info.unit = json.value("unit", "");
  if (json.contains("vertical")) {
    const SortedJson& vertical = json.at("vertical");
    info.vertical = VerticalReference{vertical.at("name").get<std::string>(),
                                      static_cast<VerticalDatum>(vertical.at("datum").get<int>())};
  }
  return info;
}

// As place_raster() finds it. Another PROJ, or one without its grids, may choose another operation.
Status find_transform(const std::string& operation, RasterInfo& info) {
  Georeference& g = info.georeference;
  if (g.crs != Georeference::Crs::other) return {};
  const LonLat middle =
      g.coordinate_of(static_cast<double>(info.columns - 1) / 2, static_cast<double>(info.rows - 1) / 2);
  auto transform = open_crs(g.definition, middle.lon, middle.lat);
  if (!transform) return bad_data(info.path.string() + ": " + transform.error().message);
  g.transform = std::move(*transform);
  if (g.transform->operation() == operation) return {};
  return bad_data(info.path.string() + ": CRS: expected PROJ's operation " + operation + ", found " +
                  g.transform->operation());
}

}  // namespace

// The structures are taken apart so that a member which is added to one stops the compilation here.
SortedJson to_json(const RasterInfo& info) {
  const auto& [path, format, columns, rows, bands, type, whole_metres, georeference, body, bounds, nodata,
               unit, vertical, overrides] = info;
  SortedJson json{
      {"path", path.string()},
      {"format", format},
      {"columns", columns},
      {"rows", rows},
      {"bands", bands},
      {"type", static_cast<int>(type)},
      {"whole_metres", whole_metres},
      {"georeference", json_of(georeference)},
      {"body", {body.name, json_of(body.shape.semi_major_m), json_of(body.shape.semi_minor_m)}},
      {"bounds", {json_of(bounds.west), json_of(bounds.south), json_of(bounds.east), json_of(bounds.north)}}};
  if (nodata) json["nodata"] = json_of(*nodata);
  if (!unit.empty()) json["unit"] = unit;
  if (vertical) json["vertical"] = {{"name", vertical->name}, {"datum", static_cast<int>(vertical->datum)}};
  return json;
}

Result<RasterInfo> raster_info_from(const SortedJson& json) {
  RasterInfo info;
  std::string operation;
  try {
    info = described(json);
    operation = json.at("georeference").value("operation", "");
  } catch (const std::exception& error) {
    return bad_data(std::string("a source: ") + error.what());
  }
  if (auto status = find_transform(operation, info); !status) return status.error();
  return info;
}

}  // namespace cairn
