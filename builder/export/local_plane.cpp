#include "builder/export/local_plane.h"

#include <algorithm>
#include <numbers>

#include <fmt/format.h>

namespace cairn {
namespace {

constexpr double kMostWidth_m = 1e6;

}  // namespace

LocalPlane::LocalPlane(LonLat centre, const Ellipsoid& ellipsoid)
    : projection_(ellipsoid.semi_major_m, ellipsoid.flattening(), 1), centre_(centre) {
  double east = 0;
  projection_.Forward(centre.lon, centre.lat, centre.lon, east, origin_);
}

std::string LocalPlane::description() const {
  return fmt::format(
      "transverse Mercator around the centre, scale 1, on an ellipsoid of {:.3f} m and a flattening of "
      "{:.12g}",
      projection_.EquatorialRadius(), projection_.Flattening());
}

PlanePoint LocalPlane::to_plane(LonLat place) const {
  PlanePoint p;
  projection_.Forward(centre_.lon, place.lat, place.lon, p.east_m, p.north_m);
  p.north_m -= origin_;
  return p;
}

LonLat LocalPlane::to_place(PlanePoint p) const {
  LonLat place;
  projection_.Reverse(centre_.lon, p.east_m, p.north_m + origin_, place.lat, place.lon);
  return place;
}

double LocalPlane::convergence(LonLat place) const {
  double east = 0, north = 0, degrees = 0, scale = 0;
  projection_.Forward(centre_.lon, place.lat, place.lon, east, north, degrees, scale);
  return degrees * std::numbers::pi / 180;
}

Result<PlaneRect> rim_on_plane(const LocalPlane& plane, const GeoBounds& region) {
  PlaneRect rect;
  constexpr int kPieces = 16;
  for (int i = 0; i <= kPieces; ++i) {
    const double lon = region.west + region.width() * i / kPieces,
                 lat = region.south + region.height() * i / kPieces;
    for (const LonLat rim : {LonLat{lon, region.south}, LonLat{lon, region.north}, LonLat{region.west, lat},
                             LonLat{region.east, lat}}) {
      const PlanePoint p = plane.to_plane(rim);
      rect = {std::min(rect.west_m, p.east_m), std::min(rect.south_m, p.north_m),
              std::max(rect.east_m, p.east_m), std::max(rect.north_m, p.north_m)};
    }
  }
  const double width = rect.east_m - rect.west_m, height = rect.north_m - rect.south_m;
  if (std::max(width, height) <= kMostWidth_m) return rect;
  return usage_error(
      fmt::format("region: expected at most {:g} km a side on a plane, found {:.0f} x {:.0f} km",
                  kMostWidth_m / 1000, width / 1000, height / 1000));
}

}  // namespace cairn
