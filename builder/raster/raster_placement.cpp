#include "builder/raster/raster_placement.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

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

/// Bounds along one edge of a projected raster from places along it. Between two of them the edge is a smooth
/// curve that leaves its chord by at most an eighth of the second difference, give or take: a fourth is
/// added.
void bound_edge(const RasterInfo& info, double c0, double r0, double c1, double r1, GeoBounds& bounds) {
  constexpr int kSteps = 64;
  LonLat before{}, here{};
  for (int i = 0; i <= kSteps; ++i) {
    const double t = static_cast<double>(i) / kSteps;
    const LonLat p = info.georeference.place_of(c0 + t * (c1 - c0), r0 + t * (r1 - r0));
    const double slack_lon = i < 2 ? 0 : std::abs(p.lon - 2 * here.lon + before.lon) / 4;
    const double slack_lat = i < 2 ? 0 : std::abs(p.lat - 2 * here.lat + before.lat) / 4;
    bounds.west = std::min(bounds.west, p.lon - slack_lon);
    bounds.east = std::max(bounds.east, p.lon + slack_lon);
    bounds.south = std::min(bounds.south, p.lat - slack_lat);
    bounds.north = std::max(bounds.north, p.lat + slack_lat);
    before = here;
    here = p;
  }
}

GeoBounds projected_bounds(const RasterInfo& info) {
  const double c = static_cast<double>(info.columns - 1);
  const double r = static_cast<double>(info.rows - 1);
  const LonLat first = info.georeference.place_of(0, 0);
  GeoBounds bounds{first.lon, first.lat, first.lon, first.lat};
  bound_edge(info, 0, 0, c, 0, bounds);
  bound_edge(info, 0, r, c, r, bounds);
  bound_edge(info, 0, 0, 0, r, bounds);
  bound_edge(info, c, 0, c, r, bounds);
  return bounds;
}

/// A corner must come back from its place: beyond a projection's domain it does not.
Status check_corner(const RasterInfo& info, double column, double row) {
  const LonLat p = info.georeference.place_of(column, row);
  const auto back = info.georeference.post_at(p);
  if (std::abs(back.column - column) < 0.01 && std::abs(back.row - row) < 0.01) return {};
  return misplaced(info,
                   fmt::format("expected a projection that covers the raster, found post ({}, {}) outside it",
                               column, row));
}

Status check_numbers(const RasterInfo& info) {
  const Georeference& g = info.georeference;
  if (info.columns < 2 || info.rows < 2 || info.columns > kMostPosts || info.rows > kMostPosts)
    return bad_data(fmt::format("{}: size: expected 2 to 2^31 posts each way, found {}×{}",
                                info.path.string(), info.columns, info.rows));
  if (!std::isfinite(g.dx) || !std::isfinite(g.dy) || g.dx <= 0 || g.dy == 0)
    return misplaced(info, fmt::format("expected a spacing above zero, found {} × {}", g.dx, g.dy));
  if (!std::isfinite(g.x0) || !std::isfinite(g.y0))
    return misplaced(info, fmt::format("expected an origin, found ({}, {})", g.x0, g.y0));
  return {};
}

}  // namespace

Status place_raster(RasterInfo& info) {
  if (auto numbers = check_numbers(info); !numbers) return numbers;
  Georeference& g = info.georeference;
  if (g.crs == Georeference::Crs::geographic) {
    restore_decimals(g.x0, g.dx, info.columns);
    restore_decimals(g.y0, g.dy, info.rows);
    take_turns_away(info);
    info.bounds = geographic_bounds(info);
  } else {
    const double c = static_cast<double>(info.columns - 1);
    const double r = static_cast<double>(info.rows - 1);
    for (const auto& [column, row] : {std::pair{0., 0.}, {c, 0.}, {0., r}, {c, r}}) {
      if (auto corner = check_corner(info, column, row); !corner) return corner;
    }
    info.bounds = projected_bounds(info);
  }
  const GeoBounds& b = info.bounds;
  if (!(b.south >= -90 - kPoleTolerance && b.north <= 90 + kPoleTolerance))
    return misplaced(info, fmt::format("expected latitudes in -90…90, found {}…{}", b.south, b.north));
  if (!(b.width() <= 360 + g.dx && b.width() >= 0 && std::isfinite(b.west)))
    return misplaced(info,
                     fmt::format("expected at most 360 degrees of longitude, found {}…{}", b.west, b.east));
  return {};
}

}  // namespace cairn
