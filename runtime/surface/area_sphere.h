#pragma once

#include "cairn/tile_id.h"
#include "runtime/view/screen_error_budget.h"

namespace cairn {

/// Returns a sphere that contains an area's surface between two heights above the ellipsoid, in metres.
SquareSphere sphere_around(const TileId& area, double low_m, double high_m, const Ellipsoid& ellipsoid);

}  // namespace cairn
