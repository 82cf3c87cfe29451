#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "cairn/pack_layout.h"
#include "cairn/render_list.h"
#include "cairn/surface_mesh.h"
#include "runtime/lod/lod_method.h"

namespace cairn::viewer {

/// A frame's tiles as a level-of-detail method takes them.
struct MethodScene {
  LodScene scene;
  /// Of each of its tiles a patch without triangles, so that patch_records() says what to show there.
  std::vector<SurfaceDraw> windows;
};

/// Of the tiles that have heights; what has none is left out, and the mesh ends there. Areas are cut at the
/// end of the world. As in the renderer's own mesh, the tolerance is one of tiles and mesh together.
MethodScene method_scene(std::span<const RenderTile* const> tiles, const PackHeader& pack);

}  // namespace cairn::viewer
