#include "builder/raster/body_placement.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include <fmt/format.h>

namespace cairn {
namespace {

std::string described(const Body& body) {
  return fmt::format("{} ({} m, {} m)", body.name, body.shape.semi_major_m, body.shape.semi_minor_m);
}

std::optional<double> number_in(std::string_view text) {
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  const bool whole = !text.empty() && error == std::errc() && end == text.data() + text.size();
  return whole && std::isfinite(number) ? std::optional(number) : std::nullopt;
}

std::vector<std::string_view> split(std::string_view text) {
  std::vector<std::string_view> parts;
  for (std::size_t comma = text.find(','); comma != std::string_view::npos; comma = text.find(',')) {
    parts.push_back(text.substr(0, comma));
    text.remove_prefix(comma + 1);
  }
  parts.push_back(text);
  return parts;
}

/// The body that the user names, on the raster's own ellipsoid where the raster is on that body and the user
/// names no ellipsoid.
Result<Body> body_told(const Body& said, const RasterInfo& info) {
  if (!info.overrides.body) return said;
  const auto told = parse_body(*info.overrides.body);
  if (!told) return bad_data(info.path.string() + ": " + told.error().message);
  if (told->shape) return Body{told->name, *told->shape};
  return told->name == said.name ? said : *known_body(told->name);
}

bool is_in_degrees(const Georeference& g) {
  return g.crs == Georeference::Crs::geographic || (g.transform && g.transform->is_geographic());
}

Error other_body(const RasterInfo& info, const Body& said, const Body& told) {
  return bad_data(fmt::format("{}: CRS: expected degrees or a CRS of {}, as it is told, found {}",
                              info.path.string(), told.name,
                              said.is_earth() ? "a projection of the Earth" : described(said)));
}

Status settle_longitudes(const CrsBody& said, RasterInfo& info) {
  Georeference& g = info.georeference;
  if (!info.overrides.longitude) return {};
  if (g.crs != Georeference::Crs::geographic)
    return bad_data(info.path.string() +
                    ": longitude: expected degrees, which can count either way, found a projection");
  const bool is_west = *info.overrides.longitude == LongitudeSense::west;
  if (is_west != said.is_west_positive) turn_longitudes(g);
  return {};
}

/// The factor by which tangents of latitudes on the raster's own ellipsoid become those of planetographic
/// ones on the body's. Where the ellipsoids differ, directions from the centre are kept.
double latitude_factor(const Ellipsoid& own, LatitudeKind kind, const Ellipsoid& body) {
  const double to_graphic = kind == LatitudeKind::planetocentric ? own.graphic_per_centric() : 1;
  return own == body ? to_graphic : to_graphic / own.graphic_per_centric() * body.graphic_per_centric();
}

}  // namespace

Result<ToldBody> parse_body(std::string_view text) {
  const std::vector<std::string_view> parts = split(text);
  const auto wrong = [&] {
    return usage_error(
        fmt::format("body: expected NAME, NAME,a,b or a,b with semi-axes in metres, 0 < b <= a, "
                    "and NAME one of {}; found {}",
                    known_body_names(), text));
  };
  ToldBody told;
  if (parts.size() != 2) {
    const auto known = known_body(parts.front());
    const bool is_new = parts.size() == 3 && !parts.front().empty() && parts.front().size() <= 31;
    if (!known && !is_new) return wrong();
    told.name = known ? known->name : std::string(parts.front());
  }
  if (parts.size() == 1) return told;
  const auto a = number_in(parts[parts.size() - 2]), b = number_in(parts.back());
  if (parts.size() > 3 || !a || !b || !(*b > 0 && *b <= *a)) return wrong();
  const Body body = body_of({*a, *b}, "unnamed");
  if (told.name.empty()) told.name = body.name;
  told.shape = told.name == body.name ? body.shape : Ellipsoid{*a, *b};
  return told;
}

void turn_longitudes(Georeference& g) {
  g.x0 = -g.x0;
  g.dx = -g.dx;
  g.x_per_row = -g.x_per_row;
}

Status put_on_body(const CrsBody& said, RasterInfo& info) {
  Georeference& g = info.georeference;
  const auto body = body_told(said.body, info);
  if (!body) return body.error();
  const bool in_degrees = is_in_degrees(g);
  // EPSG:4326 carries the degrees of any body where a format has no better code.
  const bool is_carried = said.body.is_earth() && !body->is_earth() && in_degrees && !g.transform;
  if (!is_carried && said.body.name != body->name) return other_body(info, said.body, *body);
  if (auto longitudes = settle_longitudes(said, info); !longitudes) return longitudes;
  const Ellipsoid own = is_carried ? body->shape : said.body.shape;
  const bool is_told = info.overrides.latitude.has_value();
  const bool is_said = !is_carried && said.latitude.has_value();
  const bool must_be_known = in_degrees && !own.is_sphere();
  if (must_be_known && !is_told && !is_said)
    return bad_data(
        fmt::format("{}: latitude: expected planetographic or planetocentric ones, found degrees on {}{}",
                    info.path.string(), described({body->name, own}), kLatitudeUnsettled));
  const LatitudeKind otherwise = is_said ? *said.latitude : LatitudeKind::planetographic;
  const LatitudeKind kind = info.overrides.latitude.value_or(otherwise);
  info.body = *body;
  g.latitude_factor = latitude_factor(own, kind, body->shape);
  return {};
}

Result<Body> common_body(std::span<const RasterInfo* const> rasters) {
  if (rasters.empty()) return Body{};
  const RasterInfo& first = *rasters.front();
  for (const RasterInfo* info : rasters)
    if (info->body != first.body)
      return bad_data(fmt::format("{}: body: expected {} as in {}, found {}{}", info->path.string(),
                                  described(first.body), first.path.string(), described(info->body),
                                  kBodyUnsettled));
  return first.body;
}

}  // namespace cairn
