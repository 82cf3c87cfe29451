#include "builder/raster/footprint.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <limits>

namespace cairn {
namespace {

constexpr std::array<double, 3> kTurns = {-360.0, 0.0, 360.0};
constexpr double kLine = 1e-9;  // degrees (0.1 mm): a shared edge is no area

double outside(double at, double low, double high) {
  return std::max({low - at, at - high, 0.0});
}

}  // namespace

void Footprint::add(const GeoBounds& rectangle) {
  rectangles_.push_back(rectangle);
}

GeoBounds Footprint::bounds() const {
  assert(!rectangles_.empty());
  GeoBounds all = rectangles_.front();
  for (const GeoBounds& r : rectangles_) {
    all = {std::min(all.west, r.west), std::min(all.south, r.south), std::max(all.east, r.east),
           std::max(all.north, r.north)};
  }
  if (all.width() > 360) return {-180, all.south, 180, all.north};
  if (all.west < -180.5) return {all.west + 360, all.south, all.east + 360, all.north};
  return all;
}

double Footprint::distance_to(LonLat place) const {
  double nearest = std::numeric_limits<double>::infinity();
  for (const GeoBounds& r : rectangles_) {
    const double north = outside(place.lat, r.south, r.north);
    if (north >= nearest) continue;
    for (const double turn : kTurns) {
      nearest = std::min(nearest, std::max(north, outside(place.lon + turn, r.west, r.east)));
    }
  }
  return nearest;
}

Footprint Footprint::near(const GeoBounds& rectangle, double margin) const {
  Footprint found;
  for (const GeoBounds& r : rectangles_) {
    Footprint one;
    one.add(r);
    if (one.overlaps(rectangle, margin + 2 * kLine)) found.add(r);
  }
  return found;
}

bool Footprint::contains(const GeoBounds& rectangle) const {
  return std::any_of(rectangles_.begin(), rectangles_.end(), [&](const GeoBounds& r) {
    return std::any_of(kTurns.begin(), kTurns.end(), [&](double turn) {
      return r.west <= rectangle.west + turn && rectangle.east + turn <= r.east &&
             r.south <= rectangle.south && rectangle.north <= r.north;
    });
  });
}

bool Footprint::overlaps(const GeoBounds& rectangle, double margin) const {
  const auto overlap = [&](const GeoBounds& r, double turn) {
    return rectangle.west + turn - margin < r.east - kLine &&
           r.west + kLine < rectangle.east + turn + margin && rectangle.south - margin < r.north - kLine &&
           r.south + kLine < rectangle.north + margin;
  };
  return std::any_of(rectangles_.begin(), rectangles_.end(), [&](const GeoBounds& r) {
    return std::any_of(kTurns.begin(), kTurns.end(), [&](double turn) { return overlap(r, turn); });
  });
}

}  // namespace cairn
