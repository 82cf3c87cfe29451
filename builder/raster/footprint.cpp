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

constexpr int kMostCells =
    64;  // of a rectangle that is indexed by cell, or of an area that is looked up by cell
constexpr int kCellsAround = 360;

struct Cells {
  int west = 0, south = 0, east = 0, north = 0;  // inclusive; longitudes not yet wrapped

  std::int64_t count() const { return std::int64_t{east - west + 1} * (north - south + 1); }
};

Cells cells_of(const GeoBounds& b, double margin) {
  const auto cell = [](double at) { return static_cast<int>(std::floor(std::clamp(at, -1e6, 1e6))); };
  return {cell(b.west - margin), cell(b.south - margin), cell(b.east + margin), cell(b.north + margin)};
}

int key_of(int column, int row) {
  const int wrapped = ((column % kCellsAround) + kCellsAround) % kCellsAround;
  return row * kCellsAround + wrapped;
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
  const Cells cells = cells_of(rectangle, 2 * kLine);
  if (cells.count() > kMostCells || cells.east - cells.west >= kCellsAround) {
    large_.push_back(number);
    return;
  }
  for (int row = cells.south; row <= cells.north; ++row)
    for (int column = cells.west; column <= cells.east; ++column)
      by_cell_[key_of(column, row)].push_back(number);
}

template <class Visit>
bool Footprint::any_near(const GeoBounds& area, double margin, const Visit& visit) const {
  const Cells cells = cells_of(area, margin);
  const auto all = static_cast<std::int64_t>(rectangles_.size());
  if (cells.count() > std::min<std::int64_t>(kMostCells, all) || cells.east - cells.west >= kCellsAround)
    return std::any_of(rectangles_.begin(), rectangles_.end(), visit);
  const auto visit_number = [&](std::uint32_t number) { return visit(rectangles_[number]); };
  if (std::any_of(large_.begin(), large_.end(), visit_number)) return true;
  for (int row = cells.south; row <= cells.north; ++row) {
    for (int column = cells.west; column <= cells.east; ++column) {
      const auto cell = by_cell_.find(key_of(column, row));
      if (cell != by_cell_.end() && std::any_of(cell->second.begin(), cell->second.end(), visit_number))
        return true;
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
