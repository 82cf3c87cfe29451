#include "runtime/viewer/method_scene.h"

#include <algorithm>
#include <bit>
#include <unordered_set>

namespace cairn::viewer {
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

LodTile lod_tile(const RenderTile& tile, const TileId& area, const HeightRange& range,
                 const PackHeader& pack) {
  const double quantum_m = pack.quantum_m;
  LodTile lod;
  lod.area = area;
  lod.source = tile.heights_id;
  lod.heights = tile.heights;
  lod.min_m = range.lowest * quantum_m;
  lod.max_m = range.highest * quantum_m;
  lod.error_m = static_cast<double>(tile.finer_error_m);
  lod.volume = area == tile.area
                   ? tile.volume
                   : bounding_volume(tile_bounds(area), lod.min_m, lod.max_m, Occluder(0, pack.body.shape));
  return lod;
}

}  // namespace

MethodScene method_scene(std::span<const RenderTile* const> tiles, const PackHeader& pack) {
  MethodScene out;
  const double quantum_m = pack.quantum_m;
  out.scene.tile_size = pack.tile_size;
  out.scene.quantum_m = quantum_m;
  out.scene.ellipsoid = pack.body.shape;
  std::unordered_set<TileId> taken;
  for (std::size_t i = 0; i < tiles.size(); ++i) {
    const RenderTile& tile = *tiles[i];
    if (!tile.heights) continue;
    const HeightRange range = range_of(*tile.heights);
    out.scene.lowest_m = std::min(out.scene.lowest_m, range.lowest * quantum_m);
    // Imagery may be so much finer than heights that an area has no sample: one cell of them is the least.
    const int finest = tile.heights_id.level + std::countr_zero(static_cast<unsigned>(pack.tile_size - 1));
    const TileId area = ancestor_of(tile.area, std::min(tile.area.level, finest));
    if (!taken.insert(area).second) continue;
    std::vector<TileId> parts;
    within_world(area, parts);
    for (const TileId& part : parts) {
      out.scene.tiles.push_back(lod_tile(tile, part, range, pack));
      out.windows.push_back({part, static_cast<std::uint32_t>(i)});
    }
  }
  return out;
}

}  // namespace cairn::viewer
