#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "cairn/status.h"
#include "runtime/lab/lab_terrain.h"
#include "runtime/lod/lod_method.h"
#include "runtime/view/sample_lattice.h"
#include "cairn/view_state.h"

namespace cairn {

/// A triangulated irregular network for one view.
struct GreedyTin {
  /// The first four are corners around all samples, at the height of the sample nearest to each.
  struct Vertex {
    LatticePoint point;    ///< canonical
    glm::dvec3 in_camera;  ///< metres to the right, up, and along the view
  };
  std::vector<Vertex> net;
  std::vector<LodTriangle> faces;  ///< all, also those without a sample

  std::uint64_t triangles = 0;  ///< with a sample of the viewport inside or at a corner
  std::uint64_t vertices = 0;
  std::uint64_t samples = 0;  ///< in the viewport
  double max_px = 0;          ///< the largest screen error that is left
};

/// Returns about the fewest triangles that keep a tolerance in one view: greedy insertion (Garland & Heckbert
/// 1995, algorithm III) over all finest samples in the viewport, the one with the largest screen error first,
/// until none is above the tolerance. Screen error and samples are those of FinestView.
///
/// It is no true lower bound, but free of all that a method has to keep: levels, tiles, borders, time.
/// Triangles are Delaunay in longitude and latitude.
///
/// Takes seconds, and 100 bytes per sample in the viewport. Ends early at `most_vertices`; max_px tells.
Result<GreedyTin> greedy_tin(LabTerrain& terrain, const ViewState& view, double tolerance_px,
                             std::size_t most_vertices = 2'000'000);

}  // namespace cairn
