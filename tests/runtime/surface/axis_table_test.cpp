#include "runtime/surface/axis_table.h"

#include <cmath>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>

#include "cairn/geodesy.h"

namespace cairn {
TEST_CASE("a column's and a row's entry give GeographicLib's position within ten nanometres") {
  for (const TileId& id : {TileId{-9, 0, 0}, TileId{-4, 22, 5}, TileId{0, 0, 0}, TileId{0, 359, 179},
                           TileId{3, 1733, 1080}, tile_at({86.9, 27.98}, 14)}) {
    const auto columns = column_table(id.level, id.x, 257);
    const auto rows = row_table(id.level, id.y, 257, {});
    const GeoBounds bounds = tile_bounds(id);
    for (std::size_t i = 0; i < 257; i += 16) {
      const double part = static_cast<double>(i) / 256;
      const LonLat place{bounds.west + part * bounds.width(), bounds.south + part * bounds.height()};
      if (place.lon > 180 || place.lat > 90) continue;
      for (const double h : {-400.0, 0.0, 8848.0}) {
        CAPTURE(to_string(id), place.lon, place.lat, h);
        CHECK(glm::length(position_of(columns[i], rows[i], h) - to_geocentric(place, h)) < 1e-8);
      }
    }
  }
}

TEST_CASE("tiles that share a meridian or a parallel have bit-equal entries there, also at 180 degrees") {
  CHECK(column_table(3, 100, 513).back() == column_table(3, 101, 513).front());
  CHECK(column_table(3, 100, 513).front() == column_table(0, 12, 513)[256]);
  CHECK(row_table(3, 100, 513, {}).back() == row_table(3, 101, 513, {}).front());
  CHECK(column_table(2, tiles_around(2) - 1, 513).back() == column_table(5, 0, 513).front());
  CHECK(column_table(-9, 0, 513)[360] == column_table(0, 0, 513).front());
  CHECK(row_table(1, tiles_pole_to_pole(1) - 1, 513, {}).back().y == 0);
}

}  // namespace cairn
