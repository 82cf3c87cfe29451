#include "builder/export/mercator_tiles.h"

#include <cmath>
#include <numbers>
#include <utility>

namespace cairn {
namespace {

constexpr double kPi = std::numbers::pi;

}  // namespace

LonLat mercator_place(const MercatorTile& tile, double right, double down) {
  const double x = std::ldexp(static_cast<double>(tile.x) + right, -tile.zoom);
  const double y = std::ldexp(static_cast<double>(tile.y) + down, -tile.zoom);
  return {x * 360 - 180, std::atan(std::sinh(kPi * (1 - 2 * y))) * 180 / kPi};
}

double mercator_row(double lat) {
  return (1 - std::asinh(std::tan(lat * kPi / 180)) / kPi) / 2;
}

GeoBounds mercator_bounds(const MercatorTile& tile) {
  const LonLat north_west = mercator_place(tile, 0, 0), south_east = mercator_place(tile, 1, 1);
  return {north_west.lon, south_east.lat, south_east.lon, north_west.lat};
}

std::uint64_t pmtiles_id(const MercatorTile& tile) {
  std::uint64_t id = ((std::uint64_t{1} << (2 * tile.zoom)) - 1) / 3;
  std::int64_t x = tile.x, y = tile.y;
  for (std::int64_t s = (std::int64_t{1} << tile.zoom) / 2; s > 0; s /= 2) {
    const std::int64_t right = (x & s) > 0 ? 1 : 0, below = (y & s) > 0 ? 1 : 0;
    id += static_cast<std::uint64_t>(s) * static_cast<std::uint64_t>(s) *
          static_cast<std::uint64_t>((3 * right) ^ below);
    if (below == 0) {
      if (right == 1) {
        x = s - 1 - x;
        y = s - 1 - y;
      }
      std::swap(x, y);
    }
  }
  return id;
}

}  // namespace cairn
