#pragma once

#include "builder/heights/height_node.h"
#include "builder/heights/height_plan.h"
#include "builder/mosaic/mosaic.h"
#include "cairn/height_options.h"
#include "cairn/status.h"

namespace cairn {

/// A leaf in quanta, and the samples and posts that it is measured against.
struct SampledLeaf {
  HeightNode node;
  MosaicTile sampled;
};

/// Samples a leaf of the plan from the mosaic and quantizes it.
Result<SampledLeaf> sample_leaf(const Mosaic& mosaic, const HeightPlan& plan, const TileId& id,
                                VoidMode voids);

/// Measures the leaf, at its own level and at those above it, against the posts that won there. Nothing is
/// measured of a tile that only lends its edge.
HeightNode measure_leaf(const Mosaic& mosaic, const HeightPlan& plan, SampledLeaf leaf);

}  // namespace cairn
