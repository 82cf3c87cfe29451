#pragma once

#include <span>

#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// Joins the meshes of tiles of any levels without cracks: a triangle with an edge on its area's border is
/// split at every vertex that the neighbour has there, all parts meeting in the opposite corner (T-junction
/// removal). Where voids make two tiles' fillers disagree about a vertex, both take that of the finer source.
///
/// REQUIRES: each tile's mesh has no T-junctions inside its area, and a vertex at each of its corners.
///
/// What it does to accuracy: a split triangle follows its neighbour's border. Where the triangle was within
/// δ of the tile's surface, that within g of the finest, and the inserted vertices are on the finest surface,
/// the parts are within 2(δ+g) of it: a method that promises a tolerance keeps triangles on borders between
/// different levels within half of it, or has the vertices of both sides itself.
void remove_t_junctions(const LodScene& scene, LodMesh& mesh);
/// The same where only the tiles that are not 0 here, by number, lack vertices of their neighbours.
void remove_t_junctions(const LodScene& scene, std::span<const char> lacking, LodMesh& mesh);

}  // namespace cairn
