#pragma once

#include "builder/heights/height_node.h"
#include "builder/heights/height_plan.h"
#include "builder/mosaic/mosaic.h"
#include "cairn/build_options.h"

namespace cairn {

/// Samples a leaf of the plan and measures it, at its own level and at those above it, against the posts that
/// won there.
Result<HeightNode> bake_leaf(const Mosaic& mosaic, const HeightPlan& plan, const TileId& id, VoidMode voids);

}  // namespace cairn
