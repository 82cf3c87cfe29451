#include "builder/raster/georeference.h"

#include <cmath>
#include <numbers>

#include <GeographicLib/TransverseMercator.hpp>

namespace cairn {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kWebMercatorRadius = 6378137;
constexpr double kUtmFalseEasting = 500'000;
constexpr double kUtmFalseNorthingSouth = 10'000'000;

double central_meridian(int zone) {
  return 6 * zone - 183;
}

double false_northing(bool north) {
  return north ? 0 : kUtmFalseNorthingSouth;
}

LonLat from_utm(const Georeference& g, double x, double y) {
  LonLat place;
  GeographicLib::TransverseMercator::UTM().Reverse(central_meridian(g.utm_zone), x - kUtmFalseEasting,
                                                   y - false_northing(g.utm_north), place.lat, place.lon);
  // Zones 1 and 60 reach across the antimeridian; longitudes there go on, so that a raster stays in one
  // piece.
  const double middle = central_meridian(g.utm_zone);
  place.lon = middle + std::remainder(place.lon - middle, 360);
  return place;
}

LonLat to_utm(const Georeference& g, LonLat place) {
  LonLat xy;
  GeographicLib::TransverseMercator::UTM().Forward(central_meridian(g.utm_zone), place.lat, place.lon, xy.lon,
                                                   xy.lat);
  return {xy.lon + kUtmFalseEasting, xy.lat + false_northing(g.utm_north)};
}

LonLat from_web_mercator(double x, double y) {
  return {x / (kWebMercatorRadius * kDegree), std::atan(std::sinh(y / kWebMercatorRadius)) / kDegree};
}

LonLat to_web_mercator(LonLat place) {
  return {place.lon * kDegree * kWebMercatorRadius,
          std::asinh(std::tan(place.lat * kDegree)) * kWebMercatorRadius};
}

/// The latitude whose tangent is so many times that of the given one; poles stay where they are.
double scaled_latitude(double lat, double factor) {
  if (factor == 1 || !(std::abs(lat) < 90)) return lat;
  return std::atan(factor * std::tan(lat * kDegree)) / kDegree;
}

LonLat place_of_coordinate(const Georeference& g, LonLat at) {
  switch (g.crs) {
    case Georeference::Crs::geographic:
      return at;
    case Georeference::Crs::utm:
      return from_utm(g, at.lon, at.lat);
    case Georeference::Crs::web_mercator:
      return from_web_mercator(at.lon, at.lat);
    case Georeference::Crs::other:
      g.transform->to_degrees({&at, 1});
      return at;
  }
  return {};
}

}  // namespace

bool Georeference::has_crs_of(const Georeference& o) const {
  if (crs != o.crs || latitude_factor != o.latitude_factor) return false;
  if (crs == Crs::utm) return utm_zone == o.utm_zone && utm_north == o.utm_north;
  return crs != Crs::other || transform == o.transform;
}

LonLat Georeference::place_of(double column, double row) const {
  LonLat place = place_of_coordinate(*this, coordinate_of(column, row));
  place.lat = scaled_latitude(place.lat, latitude_factor);
  return place;
}

Georeference::ColumnRow Georeference::post_at_coordinate(LonLat xy) const {
  const double x = xy.lon - x0, y = xy.lat - y0;
  if (is_straight()) return {x / dx, y / dy};
  const double determinant = dx * dy - x_per_row * y_per_column;
  return {(x * dy - y * x_per_row) / determinant, (y * dx - x * y_per_column) / determinant};
}

Georeference::ColumnRow Georeference::post_at(LonLat place) const {
  const LonLat of_crs{place.lon, scaled_latitude(place.lat, 1 / latitude_factor)};
  LonLat xy = of_crs;
  if (crs == Crs::utm) xy = to_utm(*this, of_crs);
  if (crs == Crs::web_mercator) xy = to_web_mercator(of_crs);
  if (crs == Crs::other) transform->from_degrees({&xy, 1});
  return post_at_coordinate(xy);
}

}  // namespace cairn
