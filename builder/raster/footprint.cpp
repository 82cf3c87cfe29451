#include "builder/raster/footprint.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <limits>

namespace cairn {
namespace {

constexpr std::array<double, 3> kTurns = {-360.0, 0.0, 360.0};
constexpr double kLine = 1e-9;  // degrees (0.1 mm): a shared edge is no area

constexpr int kLeastExponent = -3, kMostExponent = 18;  // of cells: 2^-exponent degrees wide

struct Cells {
  std::int64_t west = 0, south = 0, east = 0, north = 0;  // inclusive; longitudes not yet wrapped

  std::int64_t count() const { return (east - west + 1) * (north - south + 1); }
};

// Cells about as large as the rectangle, so that it lies in few of them.
int exponent_of(const GeoBounds& b) {
  const double side = std::max({b.width(), b.height(), std::ldexp(1.0, -kMostExponent)});
  return std::clamp(-std::ilogb(side) - 1, kLeastExponent, kMostExponent);
}

std::int64_t cells_around(int exponent) {
  return std::llround(std::ldexp(360.0, exponent));
}

Cells cells_of(const GeoBounds& b, double margin, int exponent) {
  const auto cell = [exponent](double at) {
    return static_cast<std::int64_t>(std::floor(std::ldexp(std::clamp(at, -1e4, 1e4), exponent)));
  };
  return {cell(b.west - margin), cell(b.south - margin), cell(b.east + margin), cell(b.north + margin)};
}

std::int64_t key_of(std::int64_t column, std::int64_t row, int exponent) {
  const std::int64_t around = cells_around(exponent);
  return row * around + ((column % around) + around) % around;
}

double outside(double at, double low, double high) {
  return std::max({low - at, at - high, 0.0});
}

// Whether `rectangle`, grown by `margin`, shares an area with `r`, in some turn around the Earth.
bool overlap(const GeoBounds& r, const GeoBounds& rectangle, double margin) {
  return std::any_of(kTurns.begin(), kTurns.end(), [&](double turn) {
    return rectangle.west + turn - margin < r.east - kLine &&
           r.west + kLine < rectangle.east + turn + margin && rectangle.south - margin < r.north - kLine &&
           r.south + kLine < rectangle.north + margin;
  });
}

}  // namespace

void Footprint::add(const GeoBounds& rectangle) {
  const auto number = static_cast<std::uint32_t>(rectangles_.size());
  rectangles_.push_back(rectangle);
  const int exponent = exponent_of(rectangle);
  Scale& scale = scales_[exponent];
  scale.all.push_back(number);
  const Cells cells = cells_of(rectangle, 2 * kLine, exponent);
  for (std::int64_t row = cells.south; row <= cells.north; ++row)
    for (std::int64_t column = cells.west; column <= cells.east; ++column)
      scale.by_cell[key_of(column, row, exponent)].push_back(number);
}

template <class Visit>
bool Footprint::any_near(const GeoBounds& area, double margin, const Visit& visit) const {
  const auto visit_number = [&](std::uint32_t number) { return visit(rectangles_[number]); };
  for (const auto& [exponent, scale] : scales_) {
    const Cells cells = cells_of(area, margin, exponent);
    if (cells.count() > static_cast<std::int64_t>(scale.all.size()) ||
        cells.east - cells.west >= cells_around(exponent)) {
      if (std::any_of(scale.all.begin(), scale.all.end(), visit_number)) return true;
      continue;
    }
    for (std::int64_t row = cells.south; row <= cells.north; ++row) {
      for (std::int64_t column = cells.west; column <= cells.east; ++column) {
        const auto cell = scale.by_cell.find(key_of(column, row, exponent));
        if (cell != scale.by_cell.end() &&
            std::any_of(cell->second.begin(), cell->second.end(), visit_number))
          return true;
      }
    }
  }
  return false;
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

LonLat Footprint::nearest_to(LonLat place) const {
  LonLat nearest = place;
  double least = std::numeric_limits<double>::infinity();
  for (const GeoBounds& r : rectangles_) {
    const double north = outside(place.lat, r.south, r.north);
    if (north >= least) continue;
    for (const double turn : kTurns) {
      const double away = std::max(north, outside(place.lon + turn, r.west, r.east));
      if (away >= least) continue;
      least = away;
      if (least == 0) return place;
      nearest = {std::clamp(place.lon + turn, r.west, r.east) - turn,
                 std::clamp(place.lat, r.south, r.north)};
    }
  }
  return nearest;
}

Footprint Footprint::near(const GeoBounds& rectangle, double margin) const {
  std::vector<const GeoBounds*> found_at;  // a rectangle lies in several cells
  any_near(rectangle, margin + 3 * kLine, [&](const GeoBounds& r) {
    if (overlap(r, rectangle, margin + 2 * kLine)) found_at.push_back(&r);
    return false;
  });
  std::sort(found_at.begin(), found_at.end());  // in the order in which they were added
  found_at.erase(std::unique(found_at.begin(), found_at.end()), found_at.end());
  Footprint found;
  for (const GeoBounds* r : found_at) found.add(*r);
  return found;
}

bool Footprint::contains(const GeoBounds& rectangle) const {
  return any_near(rectangle, 0, [&](const GeoBounds& r) {
    return std::any_of(kTurns.begin(), kTurns.end(), [&](double turn) {
      return r.west <= rectangle.west + turn && rectangle.east + turn <= r.east &&
             r.south <= rectangle.south && rectangle.north <= r.north;
    });
  });
}

bool Footprint::overlaps(const GeoBounds& rectangle, double margin) const {
  return any_near(rectangle, margin + kLine,
                  [&](const GeoBounds& r) { return overlap(r, rectangle, margin); });
}

}  // namespace cairn
