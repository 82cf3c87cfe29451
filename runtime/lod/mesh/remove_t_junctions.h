#pragma once

#include <span>

#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// Joins the meshes of tiles of any levels without cracks, by removing T-junctions on their borders.
///
/// A triangle with an edge on its area's border is split at every vertex that the neighbour has there; all
/// parts meet in the opposite corner. Where voids make two tiles' fillers differ at a vertex, both take the
/// height of the finer source. REQUIRES: each tile's mesh has no T-junction inside its area, and a vertex at
/// each of the area's corners.
///
/// Accuracy: a split triangle follows its neighbour's border. If the triangle was within δ of the tile's
/// surface, that surface within g of the finest one, and the inserted vertices are on the finest surface,
/// then the parts are within 2(δ+g) of it. A method that keeps a tolerance must keep triangles on borders
/// between different levels within half of it, or have the vertices of both sides.
void remove_t_junctions(const LodScene& scene, LodMesh& mesh);
/// Splits triangles of only those tiles whose entry in `lacking` is not 0: the others have all vertices of
/// their neighbours. `lacking` has one entry for each tile of the scene.
void remove_t_junctions(const LodScene& scene, std::span<const char> lacking, LodMesh& mesh);

/// Gives every vertex on a tile's border the height of the finest source that has it, among equals the
/// lowest. Does nothing in a scene without voids, where sources agree. remove_t_junctions() does so first.
void unify_border_heights(const LodScene& scene, LodMesh& mesh);

/// A square part of the world that has a mesh of its own.
struct MeshArea {
  LatticePoint low;        ///< the south-west corner
  std::int64_t width = 0;  ///< in lattice units
};

/// Splits triangles as remove_t_junctions() does, for any squares, each with one mesh. Heights are not
/// unified: vertices at one place must have one height.
void split_at_borders(std::span<const MeshArea> areas, std::span<LodTileMesh> meshes);

}  // namespace cairn
