#pragma once

#include "cairn/build.h"
#include "builder/heights/height_plan.h"
#include "builder/mosaic/mosaic.h"

namespace cairn {

/// Bakes up to eight leaves, spread evenly over the plan, and puts what the whole will take into `dry`: bytes
/// and seconds. Tiles that pruning leaves out are not foreseen, so both are more likely too high than too
/// low.
Status estimate(const Mosaic& mosaic, const HeightPlan& plan, VoidMode voids, int threads, DryRun& dry);

}  // namespace cairn
