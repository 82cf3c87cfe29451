#include "runtime/surface/axis_table.h"

#include <algorithm>
#include <cmath>

#include <GeographicLib/Math.hpp>

#include "runtime/view/sample_lattice.h"

namespace cairn {

ColumnEntry column_entry(std::int64_t x) {
  const double lon = x >= kLatticeAround ? -180 : place_of({x, 0}).lon;
  ColumnEntry entry;
  GeographicLib::Math::sincosd(lon, entry.y, entry.x);
  return entry;
}

RowEntry row_entry(std::int64_t y, const Ellipsoid& ellipsoid) {
  const double a = ellipsoid.semi_major_m;
  const double f = ellipsoid.flattening();
  const double e2 = f * (2 - f);
  double sin_lat = 0, cos_lat = 0;
  GeographicLib::Math::sincosd(place_of({0, std::min(y, kLatticePoleToPole)}).lat, sin_lat, cos_lat);
  const double n = a / std::sqrt(1 - e2 * sin_lat * sin_lat);
  return {n * cos_lat, cos_lat, n * (1 - e2) * sin_lat, sin_lat};
}

std::vector<ColumnEntry> column_table(int level, std::int32_t x, int tile_size) {
  const std::int64_t spacing = lattice_width(level) / (tile_size - 1);
  std::vector<ColumnEntry> table;
  table.reserve(static_cast<std::size_t>(tile_size));
  for (int i = 0; i < tile_size; ++i) table.push_back(column_entry(x * lattice_width(level) + i * spacing));
  return table;
}

std::vector<RowEntry> row_table(int level, std::int32_t y, int tile_size, const Ellipsoid& ellipsoid) {
  const std::int64_t spacing = lattice_width(level) / (tile_size - 1);
  std::vector<RowEntry> table;
  table.reserve(static_cast<std::size_t>(tile_size));
  for (int i = 0; i < tile_size; ++i)
    table.push_back(row_entry(y * lattice_width(level) + i * spacing, ellipsoid));
  return table;
}

}  // namespace cairn
