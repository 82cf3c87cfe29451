#include "runtime/gl/drawn_ground.h"

#include <cmath>

#include "runtime/gl/surface_tile.h"

namespace cairn::gl {
namespace {

LatticePoint lattice_point_at(LonLat place) {
  const double per_degree = std::ldexp(1.0, kLatticeLevel);
  return {std::llround((place.lon + 180) * per_degree), std::llround((place.lat + 90) * per_degree)};
}

}  // namespace

std::optional<double> drawn_ground_m(const RenderList& list, double quantum_m, LonLat place) {
  place.lon = std::remainder(place.lon, 360.0);
  if (place.lon == 180) place.lon = -180;
  for (const RenderTile& tile : list.tiles) {
    if (tile_at(place, tile.area.level) != tile.area) continue;
    if (!tile.heights) return std::nullopt;
    const SurfaceTile surface{tile.heights_id, tile.heights, quantum_m, true, {}};
    const double height = static_cast<double>(height_at(surface, lattice_point_at(place)));
    return std::isnan(height) ? std::nullopt : std::optional(height);
  }
  return std::nullopt;
}

}  // namespace cairn::gl
