#pragma once

#include <span>
#include <vector>

#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/remove_t_junctions.h"
#include "runtime/view/cpu_clock.h"

namespace cairn {

/// Returns the watertight mesh of what select() returns, with the CPU time of both steps.
/// `append(selected, mesh)` adds the tiles' meshes; then remove_t_junctions() splits triangles of the tiles
/// whose entry in `lacking` is not 0.
template <class Select, class Append>
LodMesh build_mesh(const LodScene& scene, std::span<const char> lacking, const Select& select,
                   const Append& append) {
  const double start = thread_cpu_s();
  const auto selected = select();
  const double end = thread_cpu_s();
  LodMesh mesh;
  append(selected, mesh);
  remove_t_junctions(scene, lacking, mesh);
  mesh.selection_s = end - start;
  mesh.building_s = thread_cpu_s() - end;
  return mesh;
}

/// Splits triangles of every tile where a neighbour has more vertices.
template <class Select, class Append>
LodMesh build_mesh(const LodScene& scene, const Select& select, const Append& append) {
  return build_mesh(scene, std::vector<char>(scene.tiles.size(), 1), select, append);
}

}  // namespace cairn
