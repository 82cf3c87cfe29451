#pragma once

#include <cstddef>
#include <optional>
#include <unordered_map>
#include <vector>

#include "runtime/surface/patch_mesh.h"
#include "runtime/surface/surface_plan.h"

namespace cairn::test {

/// The triangles of a plan's patches as they are drawn, in double precision.
class DrawnMesh {
 public:
  DrawnMesh(std::vector<SurfaceArea> areas, SurfacePlan plan);

  /// The height above the ellipsoid of the triangle over a place; nullopt where none is, or a void.
  std::optional<double> height_m(LonLat place) const;
  /// The heights of all triangles over a place, those whose chords bend over it from the next patch among them.
  std::vector<double> heights_m(LonLat place) const;

 private:
  std::vector<double> heights_in(std::size_t patch, LonLat place) const;
  std::optional<std::size_t> patch_at(LonLat place) const;
  const PatchMesh& mesh_of(std::size_t patch) const;

  std::vector<SurfaceArea> areas_;
  SurfacePlan plan_;
  std::unordered_map<TileId, std::size_t> patches_;  // by area
  mutable std::unordered_map<std::size_t, PatchMesh> meshes_;
};

}  // namespace cairn::test
