#pragma once

#include <cstddef>
#include <functional>
#include <span>
#include <vector>

#include "runtime/lod/lod_method.h"
#include "runtime/surface/lod_transition.h"
#include "runtime/surface/mesh_plan.h"

namespace cairn::gl {

/// A frame's tiles as a level-of-detail method takes them.
struct MethodScene {
  LodScene scene;
  /// Of each of its tiles a grid of one cell, so that patch_records() says what to show there.
  MeshPlan windows;
};

/// Of the tiles that have heights; what has none is left out, and the mesh ends there. Areas are cut at the
/// end of the world. The tiles' own errors are taken as 0: as in the renderer's own mesh, the tolerance is
/// one against the tiles that are shown.
MethodScene method_scene(std::span<const ShownTile* const> tiles, const LodTransition::SurfaceOf& surface_of,
                         int tile_size, double quantum_m);

}  // namespace cairn::gl
