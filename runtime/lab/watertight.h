#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>

#include "runtime/lod/lod_method.h"

namespace cairn {

/// Hashes a vertex by its place and the bits of its height. REQUIRES: a canonical point.
struct LodVertexHash {
  std::size_t operator()(const LodVertex& v) const noexcept {
    return std::hash<LatticePoint>{}(v.point) ^
           (std::bit_cast<std::uint64_t>(v.height_m) * 0x9E3779B97F4A7C15u);
  }
};

/// The faults of a mesh as a surface.
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
