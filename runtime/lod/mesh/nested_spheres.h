#pragma once

#include <cstdint>
#include <vector>

#include "runtime/lod/mesh/grid_positions.h"
#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// The nested error and radius of each vertex of a tile's bisection hierarchy, row by row (Lindstrom &
/// Pascucci 2001).
///
/// A vertex's error is the largest distance of the samples from the triangles bisected there, with the
/// sagitta of the body's curvature, in metres. Errors and spheres of a vertex contain those of all that
/// depend on it.
struct NestedSpheres {
  NestedSpheres(const LodScene& scene, const LodTile& tile, bool between_samples);

  std::uint64_t bytes() const {
    return positions.bytes() + (errors_m.size() + radii_m.size()) * sizeof(float);
  }

  bool between_samples;  ///< places between the samples count
  GridPositions positions;
  std::vector<float> errors_m;
  std::vector<float> radii_m;
};

}  // namespace cairn
