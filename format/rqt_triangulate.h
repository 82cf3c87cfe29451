#pragma once

#include "cairn/height_tile.h"
#include "format/rqt_steps.h"

namespace cairn {

/// Returns `steps` triangulations, off the tile's samples by less than tolerance_m, 2·tolerance_m,
/// 4·tolerance_m … (Intel 2012, Algorithm 2). A vertex is in one if a vertex that depends on it is, or if its
/// bisection_errors() is not below the tolerance. Only this tile is considered; RqtBorders makes neighbours
/// agree. REQUIRES: tolerance_m > 0, 1 <= steps <= kMostRqtSteps.
RqtSteps triangulate(const HeightTile& tile, double quantum_m, float tolerance_m, int steps, bool rising);

}  // namespace cairn
