#pragma once

#include <cstdint>

#include "runtime/lod_method.h"

namespace cairn {

/// What is wrong with a mesh as a surface.
struct MeshFaults {
  std::uint64_t cracks = 0;  ///< edges inside the map without exactly one triangle on each side; two edges
                             ///< are the same where their ends agree in place and height
  std::uint64_t degenerate = 0;  ///< triangles without area in longitude and latitude, or facing down
  double area_error =
      0;  ///< |the triangles' area less the drawn tiles'|, as a share of it: gaps and overlaps
};

/// Checks a mesh that was not culled. Edges on the outer border of the scene's areas may have one triangle.
MeshFaults find_faults(const LodScene& scene, const LodMesh& mesh);

}  // namespace cairn
