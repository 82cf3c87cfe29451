#include "runtime/surface/axis_table.h"

#include <algorithm>
#include <cmath>

#include <GeographicLib/Constants.hpp>
#include <GeographicLib/Math.hpp>

namespace cairn::gl {

std::vector<ColumnEntry> column_table(int level, std::int32_t x, int tile_size) {
  const double width = tile_width_degrees(level);
  std::vector<ColumnEntry> table(static_cast<std::size_t>(tile_size));
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double east_of_origin = (x + static_cast<double>(i) / (tile_size - 1)) * width;
    const double lon = east_of_origin >= 360 ? -180 : east_of_origin - 180;
    GeographicLib::Math::sincosd(lon, table[i].y, table[i].x);
  }
  return table;
}

std::vector<RowEntry> row_table(int level, std::int32_t y, int tile_size) {
  const double width = tile_width_degrees(level);
  const double a = GeographicLib::Constants::WGS84_a();
  const double f = GeographicLib::Constants::WGS84_f();
  const double e2 = f * (2 - f);
  std::vector<RowEntry> table(static_cast<std::size_t>(tile_size));
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double lat = std::min((y + static_cast<double>(i) / (tile_size - 1)) * width - 90, 90.0);
    double sin_lat = 0, cos_lat = 0;
    GeographicLib::Math::sincosd(lat, sin_lat, cos_lat);
    const double n = a / std::sqrt(1 - e2 * sin_lat * sin_lat);
    table[i] = {n * cos_lat, cos_lat, n * (1 - e2) * sin_lat, sin_lat};
  }
  return table;
}

}  // namespace cairn::gl
