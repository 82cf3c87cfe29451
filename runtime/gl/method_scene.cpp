#include "runtime/gl/method_scene.h"

#include <algorithm>
#include <unordered_set>

namespace cairn::gl {
namespace {

bool overhangs(const TileId& id) {
  const LatticePoint corner = south_west_of(id);
  const std::int64_t width = lattice_width(id.level);
  return corner.x + width > kLatticeAround || corner.y + width > kLatticePoleToPole;
}

void within_world(const TileId& area, std::vector<TileId>& out) {
  if (!overhangs(area)) return out.push_back(area);
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (is_valid(child)) within_world(child, out);
  }
}

LodTile lod_tile(const RenderTile& tile, const TileId& area, const Relief& relief) {
  LodTile lod;
  lod.area = area;
  lod.source = tile.heights_id;
  lod.heights = tile.heights;
  lod.min_m = static_cast<double>(relief.low_m);
  lod.max_m = static_cast<double>(relief.high_m);
  lod.volume =
      area == tile.area ? tile.volume : bounding_volume(tile_bounds(area), lod.min_m, lod.max_m, Occluder(0));
  return lod;
}

}  // namespace

MethodScene method_scene(std::span<const ShownTile* const> tiles, const LodTransition::SurfaceOf& surface_of,
                         int tile_size, double quantum_m) {
  MethodScene out;
  out.scene.tile_size = tile_size;
  out.scene.quantum_m = quantum_m;
  std::unordered_set<TileId> taken;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const RenderTile& tile = tiles[i]->tile;
    const SurfaceTile* surface = surface_of(tile);
    if (!surface) continue;
    const Relief& relief = surface->relief.whole;
    out.scene.lowest_m = std::min(out.scene.lowest_m, static_cast<double>(relief.low_m));
    // Imagery may be so much finer than heights that an area has no sample: one cell of them is the least.
    const int finest = tile.heights_id.level + cells_log2_of(tile_size);
    const TileId area = ancestor_of(tile.area, std::min(tile.area.level, finest));
    if (!taken.insert(area).second) continue;
    std::vector<TileId> parts;
    within_world(area, parts);
    for (const TileId& part : parts) {
      out.scene.tiles.push_back(lod_tile(tile, part, relief));
      out.windows.patches.push_back({part, i, 0, 1, 1, 0, 0});
    }
  }
  return out;
}

}  // namespace cairn::gl
