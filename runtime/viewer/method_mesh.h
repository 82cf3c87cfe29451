#pragma once

#include "cairn/surface_mesh.h"
#include "runtime/lod/lod_method.h"

namespace cairn::viewer {

/// A method's mesh as the shaders take it; the number of a vertex's patch is that of its tile in the scene.
SurfaceWalls vertices_of(const LodMesh& mesh, const LodScene& scene);

}  // namespace cairn::viewer
