#include "cairn/object_placing.h"

#include <algorithm>
#include <cmath>

namespace cairn {
namespace {

constexpr double kSteps = 65536;

std::uint16_t step_of(double degrees, double width) {
  return static_cast<std::uint16_t>(std::clamp(std::floor(degrees / width * kSteps), 0.0, kSteps - 1));
}

}  // namespace

TileObject tile_object(const ObjectPlacing& placing, const Body& body, int coarsest_level) {
  TileObject out;
  PlacedObject& object = out.object;
  object.scale = static_cast<std::uint16_t>(std::lround(std::clamp(placing.scale * 4096, 1.0, 65535.0)));
  object.heading = static_cast<std::uint16_t>(
      std::llround(std::remainder(placing.heading_degrees, 360.0) * (kSteps / 360)) & 0xFFFF);
  const int level = object_level(placing.size_m * object.scale_factor(), body);
  out.tile = tile_at(placing.at, std::max(level, coarsest_level));
  const GeoBounds bounds = tile_bounds(out.tile);
  double east = std::fmod(placing.at.lon - bounds.west, 360.0);
  if (east < 0) east += 360;
  object.x = step_of(east, bounds.width());
  object.y = step_of(placing.at.lat - bounds.south, bounds.height());
  return out;
}

}  // namespace cairn
