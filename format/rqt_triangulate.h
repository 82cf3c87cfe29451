#pragma once

#include "cairn/height_tile.h"
#include "format/rqt_steps.h"

namespace cairn {

/// The triangulations of a tile whose samples they are off by less than tolerance_m, 2·tolerance_m,
/// 4·tolerance_m …, `steps` of them [3, Algorithm 2]: a vertex is in one where a vertex that needs it is, or
/// where the triangles that it is the base of are off by as much, see bisection_errors(). Nothing outside the
/// tile is looked at: RqtBorders makes neighbours agree. REQUIRES: tolerance_m > 0, 1 <= steps <=
/// kMostRqtSteps.
RqtSteps triangulate(const HeightTile& tile, double quantum_m, float tolerance_m, int steps, bool rising);

}  // namespace cairn
