#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <unordered_map>
#include <vector>

#include <glm/vec3.hpp>

#include "runtime/surface/mesh_plan.h"

namespace cairn::test {

/// The triangles that terrain.vert draws for a plan, in double precision.
class DrawnMesh {
 public:
  DrawnMesh(std::vector<gl::MeshArea> areas, gl::MeshPlan plan);

  /// The height above the ellipsoid of the triangle over a place; nullopt where none is, or a void.
  std::optional<double> height_m(LonLat place) const;

 private:
  struct Vertex {
    glm::dvec3 position;  // geocentric
    bool is_void = false;
  };
  const gl::GridPatch* patch_at(LonLat place) const;
  Vertex vertex(const gl::GridPatch& patch, int column, int row) const;
  /// The cell whose columns and rows hold the place, as {column, row}.
  static std::array<int, 2> cell_at(const gl::GridPatch& patch, LonLat place);
  std::optional<double> height_over(const gl::GridPatch& patch, int column, int row, LonLat place) const;

  std::vector<gl::MeshArea> areas_;
  gl::MeshPlan plan_;
  std::unordered_map<TileId, std::size_t> patches_;  // by area
};

}  // namespace cairn::test
