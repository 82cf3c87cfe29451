#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "builder/export/height_samples.h"

namespace cairn {

/// A triangle mesh as its reader decodes it, in the coordinates of HeightSamples.
struct DecodedMesh {
  std::vector<double> columns;
  std::vector<double> rows;
  std::vector<double> metres;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

/// How far a mesh is from the ground.
struct MeshError {
  /// A place between the samples of a grid.
  struct Place {
    std::size_t grid = 0;
    double column = 0;
    double row = 0;
  };
  double metres = 0;         ///< the largest vertical distance, the grids' own errors included
  std::vector<Place> above;  ///< where it is above a limit; places may come more than once
};

/// The exact largest vertical distance between the mesh and the bilinear surfaces of the grids, each plus its
/// grid's own error. A linear less a bilinear function has no maximum within a cell but along the mesh's
/// edges and at samples, so these are what is looked at. Cells with a void do not count.
/// REQUIRES: the mesh lies between 0 and `side`.
MeshError measure_mesh(const DecodedMesh& mesh, std::span<const HeightSamples> grids, std::int64_t side,
                       double limit_m);

}  // namespace cairn
