#pragma once

#include "cairn/surface_mesh.h"
#include "runtime/surface/patch_partition.h"
#include "runtime/surface/side_joints.h"

namespace cairn {

/// Joins the rims of patches that do not share their vertices, with upright triangles.
///
/// A wall has every edge of the one rim and every edge of the other, so that each is the edge of two
/// triangles. Where walls meet, they have common vertices: at a segment's ends the way from one rim to the
/// other goes through every rim's vertex there that lies between. A wall is as high as the tiles' errors are,
/// where all tiles are there that the eye asks for; where a source ends it is a cliff.
void append_walls(const PatchPartition& partition, const SideJoints& joints, SurfaceWalls& walls);

}  // namespace cairn
