#include "runtime/lod/mesh/tile_culling.h"

#include "runtime/view/view_frustum.h"

namespace cairn {

std::vector<std::size_t> tiles_in_view(const LodScene& scene, const LodView& view) {
  const ViewFrustum frustum(view.view, Occluder(scene.lowest_m, scene.ellipsoid));
  std::vector<std::size_t> drawn;
  for (std::size_t i = 0; i < scene.tiles.size(); ++i) {
    if (!view.cull || frustum.sees(scene.tiles[i].volume)) drawn.push_back(i);
  }
  return drawn;
}

}  // namespace cairn
