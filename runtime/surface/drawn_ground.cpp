#include "runtime/surface/drawn_ground.h"

#include <cmath>

#include "runtime/surface/surface_tile.h"

namespace cairn {
namespace {

LatticePoint lattice_point_at(LonLat place) {
  const double per_degree = std::ldexp(1.0, kLatticeLevel);
  return {std::llround((place.lon + 180) * per_degree), std::llround((place.lat + 90) * per_degree)};
}

LonLat within_the_world(LonLat place) {
  place.lon = std::remainder(place.lon, 360.0);
  if (place.lon == 180) place.lon = -180;
  return place;
}

bool shows(const RenderTile& tile, LonLat place) {
  return tile_at(place, tile.area.level) == tile.area;
}

std::optional<double> height_of(const RenderTile& tile, double quantum_m, double detail, LonLat place) {
  if (!tile.heights) return std::nullopt;
  SurfaceTile surface;
  surface.id = tile.heights_id;
  surface.heights = tile.heights;
  surface.quantum_m = quantum_m;
  const float height = height_at(ShownSurface::of(&surface, detail), lattice_point_at(place));
  return std::isnan(height) ? std::nullopt : std::optional(static_cast<double>(height));
}

}  // namespace

std::optional<double> drawn_ground_m(const RenderList& list, double quantum_m, LonLat place) {
  place = within_the_world(place);
  for (const RenderTile& tile : list.tiles) {
    if (shows(tile, place)) return height_of(tile, quantum_m, tile.heights_id.level, place);
  }
  return std::nullopt;
}

std::optional<double> drawn_ground_m(std::span<const ShownTile> tiles, double quantum_m, LonLat place) {
  place = within_the_world(place);
  for (const ShownTile& shown : tiles) {
    if (shows(shown.tile, place)) return height_of(shown.tile, quantum_m, shown.detail, place);
  }
  return std::nullopt;
}

}  // namespace cairn
