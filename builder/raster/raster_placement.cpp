#include "builder/raster/raster_placement.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "builder/raster/body_placement.h"
#include "builder/raster/crs.h"

namespace cairn {
namespace {

constexpr double kSnap = 1e-5;                              // of the spacing
constexpr double kPoleTolerance = 1e-6;                     // degrees
constexpr std::int64_t kMostPosts = std::int64_t{1} << 31;  // along one axis

Error misplaced(const RasterInfo& info, const std::string& what) {
  return bad_data(info.path.string() + ": georeference: " + what);
}

/// The spacing as one part of a whole number of posts a degree, and the origin on half posts of that grid,
/// where the last post hardly moves by it.
void restore_decimals(double& origin, double& spacing, std::int64_t count) {
  const double per_degree = std::round(1 / std::abs(spacing));
  if (per_degree < 1) return;
  const double exact = std::copysign(1 / per_degree, spacing);
  const double halves = std::round(origin * per_degree * 2);
  const double exact_origin = halves / (per_degree * 2);
  const double drift = std::abs(exact - spacing) * static_cast<double>(count);
  const double allowed = kSnap * std::abs(exact);
  if (drift > allowed || std::abs(exact_origin - origin) > allowed) return;
  spacing = exact;
  origin = exact_origin;
}

GeoBounds geographic_bounds(const RasterInfo& info) {
  const Georeference& g = info.georeference;
  const double x1 = g.x0 + static_cast<double>(info.columns - 1) * g.dx;
  const double y1 = g.y0 + static_cast<double>(info.rows - 1) * g.dy;
  return {std::min(g.x0, x1), std::min(g.y0, y1), std::max(g.x0, x1), std::max(g.y0, y1)};
}

void take_turns_away(RasterInfo& info) {
  const double half_post = std::abs(info.georeference.dx) / 2;
  const double west = geographic_bounds(info).west;
  info.georeference.x0 -= 360 * std::floor((west + 180 + half_post) / 360);
}

bool is_regular(const Georeference& g) {
  return g.is_lattice();
}

bool is_close(const Georeference::ColumnRow& a, double column, double row) {
  return std::abs(a.column - column) < 0.01 && std::abs(a.row - row) < 0.01;
}

/// A post must come back from its place: beyond a projection's domain it does not.
Status check_post(const RasterInfo& info, double column, double row) {
  const LonLat p = info.georeference.place_of(column, row);
  if (std::isfinite(p.lon) && is_close(info.georeference.post_at(p), column, row)) return {};
  return misplaced(info,
                   fmt::format("expected a projection that covers the raster, found post ({}, {}) outside it",
                               column, row));
}

Status check_posts(const RasterInfo& info) {
  constexpr int kSteps = 5;
  for (int j = 0; j <= kSteps; ++j) {
    for (int i = 0; i <= kSteps; ++i) {
      const auto column = std::floor(static_cast<double>(info.columns - 1) * i / kSteps);
      const auto row = std::floor(static_cast<double>(info.rows - 1) * j / kSteps);
      if (auto post = check_post(info, column, row); !post) return post;
    }
  }
  return {};
}

/// Whether this pole is a point of the raster's plane that lies among the posts, or within one of them. Where
/// a projection draws the pole as a line (plate carrée), its places differ by longitude.
bool holds_pole(const RasterInfo& info, double lat) {
  const Georeference& g = info.georeference;
  const bool degrees =
      g.crs == Georeference::Crs::geographic || (g.transform && g.transform->is_geographic());
  if (degrees) return false;
  const auto pole = g.post_at({0, lat}), again = g.post_at({100, lat});
  if (!is_close(again, pole.column, pole.row)) return false;
  return pole.column > -1 && pole.row > -1 && pole.column < static_cast<double>(info.columns) &&
         pole.row < static_cast<double>(info.rows);
}

struct EdgePost {
  double column = 0;
  double row = 0;
  LonLat place;
};

/// How far east it is from one post of an edge to another. Beside a pole longitudes run through half a turn
/// in less than a post, so a large step is halved until its direction shows.
double step_east(const Georeference& g, const EdgePost& a, const EdgePost& b, int depth) {
  constexpr double kPlain = 60;
  constexpr int kMostHalvings = 40;
  const double step = std::remainder(b.place.lon - a.place.lon, 360);
  if (std::abs(step) <= kPlain || depth == kMostHalvings) return step;
  EdgePost middle{(a.column + b.column) / 2, (a.row + b.row) / 2, {}};
  middle.place = g.place_of(middle.column, middle.row);
  return step_east(g, a, middle, depth + 1) + step_east(g, middle, b, depth + 1);
}

/// A raster's rim, around once from corner to corner, longitudes without a jump.
struct Rim {
  std::size_t steps = 0;  ///< of each edge
  std::vector<LonLat> places;

  bool is_corner(std::size_t i) const { return i % steps == 0; }
};

/// Whether the corners lie so near to one another, and so far from the poles, that edges hardly bend.
bool is_narrow(const std::array<EdgePost, 5>& corners) {
  constexpr double kNarrow = 0.25, kFarNorth = 80;  // degrees
  return std::all_of(corners.begin(), corners.end(), [&](const EdgePost& corner) {
    const LonLat a = corner.place, b = corners[0].place;
    return std::abs(a.lat) < kFarNorth && std::abs(a.lat - b.lat) < kNarrow &&
           std::abs(std::remainder(a.lon - b.lon, 360)) < kNarrow;
  });
}

Rim rim_of(const RasterInfo& info) {
  const double c = static_cast<double>(info.columns - 1), r = static_cast<double>(info.rows - 1);
  std::array<EdgePost, 5> corners = {{{0, 0, {}}, {c, 0, {}}, {c, r, {}}, {0, r, {}}, {0, 0, {}}}};
  for (EdgePost& corner : corners) corner.place = info.georeference.place_of(corner.column, corner.row);
  Rim rim;
  rim.steps = is_narrow(corners) ? 4 : 24;
  EdgePost before = corners[0];
  double lon = before.place.lon;
  rim.places.push_back(before.place);
  for (std::size_t edge = 0; edge < 4; ++edge) {
    const EdgePost& from = corners[edge];
    const EdgePost& to = corners[edge + 1];
    for (std::size_t i = 1; i <= rim.steps; ++i) {
      const double t = static_cast<double>(i) / static_cast<double>(rim.steps);
      EdgePost here{from.column + t * (to.column - from.column), from.row + t * (to.row - from.row), {}};
      here.place = i == rim.steps ? to.place : info.georeference.place_of(here.column, here.row);
      lon += step_east(info.georeference, before, here, 0);
      rim.places.push_back({lon, here.place.lat});
      before = here;
    }
  }
  return rim;
}

/// Between two of its places an edge is a smooth curve that leaves its chord by at most an eighth of the
/// second difference, give or take: a fourth is added.
GeoBounds bounds_around(const Rim& around) {
  const std::vector<LonLat>& rim = around.places;
  GeoBounds bounds{rim[0].lon, rim[0].lat, rim[0].lon, rim[0].lat};
  for (std::size_t i = 0; i < rim.size(); ++i) {
    const bool inner = !around.is_corner(i);
    const double lon = inner ? std::abs(rim[i + 1].lon - 2 * rim[i].lon + rim[i - 1].lon) / 4 : 0;
    const double lat = inner ? std::abs(rim[i + 1].lat - 2 * rim[i].lat + rim[i - 1].lat) / 4 : 0;
    bounds.west = std::min(bounds.west, rim[i].lon - lon);
    bounds.east = std::max(bounds.east, rim[i].lon + lon);
    bounds.south = std::min(bounds.south, std::max(rim[i].lat - lat, -90.0));
    bounds.north = std::max(bounds.north, std::min(rim[i].lat + lat, 90.0));
  }
  return bounds;
}

/// The bounds of posts that are not on a lattice of longitude and latitude.
Result<GeoBounds> projected_bounds(const RasterInfo& info) {
  const Rim around = rim_of(info);
  const std::vector<LonLat>& rim = around.places;
  const bool finite = std::all_of(rim.begin(), rim.end(),
                                  [](LonLat p) { return std::isfinite(p.lon) && std::isfinite(p.lat); });
  if (!finite)
    return misplaced(info,
                     "expected a projection that covers the raster, found a part of its rim outside it");
  GeoBounds bounds = bounds_around(around);
  const bool north = holds_pole(info, 90), south = holds_pole(info, -90);
  if (north || south) {
    bounds.west = -180;
    bounds.east = 180;
    if (north) bounds.north = 90;
    if (south) bounds.south = -90;
    return bounds;
  }
  if (std::abs(rim.back().lon - rim.front().lon) > 1)
    return misplaced(
        info,
        "expected a raster in one piece, found one that the antimeridian of its projection or a pole cuts");
  const double turns = std::floor((bounds.west + 180) / 360);
  bounds.west -= 360 * turns;
  bounds.east -= 360 * turns;
  return bounds;
}

/// Whether the degrees of a CRS are those that it is transformed to, longitudes with the given sign.
bool keeps_degrees(const RasterInfo& info, double sign) {
  constexpr double kSame = 1e-9;  // degrees: 0.1 mm on the Earth
  const Georeference& g = info.georeference;
  const double c = static_cast<double>(info.columns - 1), r = static_cast<double>(info.rows - 1);
  for (const auto& [column, row] : {std::pair{c / 2, r / 2}, {0., 0.}, {c, 0.}, {0., r}, {c, r}}) {
    const LonLat at = g.coordinate_of(column, row), place = g.place_of(column, row);
    const bool same = std::abs(std::remainder(sign * at.lon - place.lon, 360)) < kSame &&
                      std::abs(at.lat - place.lat) < kSame;
    if (!same) return false;
  }
  return true;
}

/// Finds another CRS's transform, and what the CRS says of the body. One of the body's own degrees is not
/// another.
Result<CrsBody> find_crs(RasterInfo& info) {
  CrsBody said;
  Georeference& g = info.georeference;
  if (g.crs != Georeference::Crs::other) return said;
  const double c = static_cast<double>(info.columns - 1), r = static_cast<double>(info.rows - 1);
  const LonLat middle = g.coordinate_of(c / 2, r / 2);
  auto transform = open_crs(g.definition, middle.lon, middle.lat);
  if (!transform) return bad_data(info.path.string() + ": " + transform.error().message);
  g.transform = std::move(*transform);
  said.body = g.transform->body();
  said.latitude = g.transform->latitude();
  if (!g.transform->is_geographic()) return said;
  said.is_west_positive = !said.body.is_earth() && keeps_degrees(info, -1) && !keeps_degrees(info, 1);
  if (!said.is_west_positive && !keeps_degrees(info, 1)) return said;
  if (said.is_west_positive) turn_longitudes(g);
  g.crs = Georeference::Crs::geographic;
  g.transform = nullptr;
  g.definition.clear();
  return said;
}

/// Puts a CRS that the user names in place of the file's.
void use_crs(const std::string& definition, RasterInfo& info) {
  constexpr std::string_view kEpsg = "EPSG:";
  constexpr int kWgs84InThreeDimensions = 4979;
  int code = 0;
  const bool is_code = definition.starts_with(kEpsg) &&
                       definition.find_first_not_of("0123456789", kEpsg.size()) == std::string::npos;
  if (is_code) std::from_chars(definition.data() + kEpsg.size(), definition.data() + definition.size(), code);
  if (set_crs(info.georeference, code)) {
    if (code == kWgs84InThreeDimensions) info.vertical = vertical_reference(code);
    return;
  }
  set_other_crs(info.georeference, definition);
  if (const auto vertical = find_vertical_crs(definition)) {
    info.vertical = vertical_reference_named(vertical->name);
    if (vertical->is_ellipsoidal) info.vertical->datum = VerticalDatum::ellipsoid;
  }
}

Status check_numbers(const RasterInfo& info) {
  const Georeference& g = info.georeference;
  if (info.columns < 2 || info.rows < 2 || info.columns > kMostPosts || info.rows > kMostPosts)
    return bad_data(fmt::format("{}: size: expected 2 to 2^31 posts each way, found {}×{}",
                                info.path.string(), info.columns, info.rows));
  const double area = g.dx * g.dy - g.x_per_row * g.y_per_column;
  if (!std::isfinite(area) || area == 0)
    return misplaced(info, fmt::format("expected a spacing other than zero, found {} × {}", g.dx, g.dy));
  if (!std::isfinite(g.x0) || !std::isfinite(g.y0))
    return misplaced(info, fmt::format("expected an origin, found ({}, {})", g.x0, g.y0));
  return {};
}

/// Square degrees inside a rim, by Gauss's formula.
double area_inside(const std::vector<LonLat>& rim) {
  double twice = 0;
  for (std::size_t i = 0; i + 1 < rim.size(); ++i)
    twice += rim[i].lon * rim[i + 1].lat - rim[i + 1].lon * rim[i].lat;
  return std::abs(twice) / 2;
}

/// A part of a raster's posts as a raster.
RasterInfo part_of(const RasterInfo& info, std::int64_t column, std::int64_t row, std::int64_t columns,
                   std::int64_t rows) {
  RasterInfo part = info;
  const LonLat first = info.georeference.coordinate_of(static_cast<double>(column), static_cast<double>(row));
  part.georeference.x0 = first.lon;
  part.georeference.y0 = first.lat;
  part.columns = columns;
  part.rows = rows;
  return part;
}

/// Adds the raster's bounds, or those of its quarters where much of the bounds holds no posts.
void add_tight_bounds(const RasterInfo& info, int halvings, std::vector<GeoBounds>& found) {
  constexpr double kMuch = 0.7;
  constexpr std::int64_t kLeastPosts = 16;
  const auto whole = projected_bounds(info);
  if (!whole) return;
  const bool is_tight =
      whole->width() < 360 && area_inside(rim_of(info).places) > kMuch * whole->width() * whole->height();
  if (halvings == 0 || is_tight || std::min(info.columns, info.rows) < 2 * kLeastPosts) {
    found.push_back(*whole);
    return;
  }
  const std::int64_t c = info.columns / 2, r = info.rows / 2;
  for (const RasterInfo& quarter :
       {part_of(info, 0, 0, c + 1, r + 1), part_of(info, c, 0, info.columns - c, r + 1),
        part_of(info, 0, r, c + 1, info.rows - r), part_of(info, c, r, info.columns - c, info.rows - r)})
    add_tight_bounds(quarter, halvings - 1, found);
}

}  // namespace

void move_near(const GeoBounds& to, GeoBounds& moved) {
  const double apart = (moved.west + moved.east) / 2 - (to.west + to.east) / 2;
  const double turns = std::round(apart / 360) * 360;
  moved.west -= turns;
  moved.east -= turns;
}

std::vector<GeoBounds> tight_bounds(const RasterInfo& info, int halvings) {
  if (is_regular(info.georeference) || halvings == 0) return {info.bounds};
  std::vector<GeoBounds> bounds;
  add_tight_bounds(info, halvings, bounds);
  for (GeoBounds& part : bounds) move_near(info.bounds, part);
  return bounds;
}

Status place_raster(RasterInfo& info) {
  if (auto numbers = check_numbers(info); !numbers) return numbers;
  if (info.overrides.crs) use_crs(*info.overrides.crs, info);
  const auto crs = find_crs(info);
  if (!crs) return crs.error();
  if (auto body = put_on_body(*crs, info); !body) return body;
  Georeference& g = info.georeference;
  if (is_regular(g)) {
    restore_decimals(g.x0, g.dx, info.columns);
    restore_decimals(g.y0, g.dy, info.rows);
    take_turns_away(info);
    info.bounds = geographic_bounds(info);
  } else {
    if (auto posts = check_posts(info); !posts) return posts;
    const auto bounds = projected_bounds(info);
    if (!bounds) return bounds.error();
    info.bounds = *bounds;
  }
  const GeoBounds& b = info.bounds;
  if (!(b.south >= -90 - kPoleTolerance && b.north <= 90 + kPoleTolerance))
    return misplaced(info, fmt::format("expected latitudes in -90…90, found {}…{}", b.south, b.north));
  const double spacing = is_regular(g) ? g.dx : 0.001;
  if (!(b.width() <= 360 + spacing && b.width() >= 0 && std::isfinite(b.west)))
    return misplaced(info,
                     fmt::format("expected at most 360 degrees of longitude, found {}…{}", b.west, b.east));
  return {};
}

}  // namespace cairn
