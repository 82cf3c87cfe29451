#pragma once

#include <span>
#include <vector>

#include "runtime/surface/patch_partition.h"

namespace cairn {

/// How the patches of a partition meet.
struct SideJoints {
  std::vector<SideVertices> sides;    ///< of each patch
  std::vector<SharedSegment> walled;  ///< where the two sides keep rims of their own, for walls to join
};

/// Gives patches that touch and show one surface equal vertices along their common sides: those of both, and
/// what these need elsewhere, so that each stays a triangulation of its hierarchy and keeps its tolerance.
///
/// Two patches show one surface where their tiles are of one level, shown with equal detail, and their
/// lattices have one spacing; tiles of a level have equal samples along their common edge, but for voids.
/// Elsewhere both rims have a vertex where the segment ends. May make a patch's lattice finer for that.
SideJoints join_sides(PatchPartition& partition);

}  // namespace cairn
