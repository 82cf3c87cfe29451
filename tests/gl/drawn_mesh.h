#pragma once

#include <cstddef>
#include <optional>
#include <unordered_map>
#include <vector>

#include <glm/vec3.hpp>

#include "runtime/gl/mesh_plan.h"

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
  Vertex vertex(const gl::GridPatch& patch, int column, int row) const;
  std::optional<double> height_over(const gl::GridPatch& patch, int column, int row, LonLat place) const;

  std::vector<gl::MeshArea> areas_;
  gl::MeshPlan plan_;
  std::unordered_map<TileId, std::size_t> patches_;  // by area
};

}  // namespace cairn::test
