#include "runtime/lab/scene_use.h"

#include <map>

#include "cairn/loaded_tile.h"
#include "runtime/lod/mesh/screen.h"
#include "runtime/lod/mesh/tile_window.h"
#include "runtime/view/view_frustum.h"

namespace cairn {
namespace {

constexpr double kUseful_px = 0.25;

bool is_useful(const PackReader& pack, const LodTile& tile, const Screen& screen, const ViewFrustum& volume) {
  if (!volume.sees(tile.volume)) return false;
  if (tile.source.level == kMinLevel) return true;
  const auto parent = pack.find(Layer::heights, parent_of(tile.source));
  if (!parent) return true;
  const double error_m = static_cast<double>(parent->geometric_error_m);
  return error_m * screen.pixels_per_radian() > kUseful_px * tile.volume.distance_m(screen.camera().position);
}

}  // namespace

SceneUse use_of(const LabTerrain& terrain, const LodScene& scene, const ViewState& view) {
  const Screen screen(view);
  const ViewFrustum volume(view, Occluder(terrain.lowest_m(), view.ellipsoid));
  SceneUse use;
  std::map<TileId, bool> useful;
  for (const LodTile& tile : scene.tiles) {
    const auto cells = static_cast<std::uint64_t>(TileWindow(scene, tile).cells());
    use.triangles += 2 * cells * cells;
    bool& any = useful[tile.source];
    any = any || is_useful(terrain.pack(), tile, screen, volume);
  }
  for (const auto& [source, is_of_use] : useful) {
    const IndexEntry entry = *terrain.pack().find(Layer::heights, source);
    use.sources.push_back(source);
    use.useful_tiles += is_of_use ? 1 : 0;
    use.decoded_bytes += decoded_bytes_bound(entry, scene.tile_size);
    use.loaded_bytes += entry.bytes;
    use.useful_loaded_bytes += is_of_use ? entry.bytes : 0;
  }
  return use;
}

}  // namespace cairn
