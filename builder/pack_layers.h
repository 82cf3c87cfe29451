#pragma once

#include <memory>
#include <optional>

#include "builder/build_options.h"
#include "builder/build_plan.h"
#include "builder/imagery_mosaic.h"
#include "builder/mosaic.h"
#include "builder/tile_tree.h"

namespace cairn {

/// What a bake makes a pack of: heights, imagery or both.
struct PackLayers {
  std::unique_ptr<Mosaic> heights;         ///< null where there are no DEMs
  std::optional<BuildPlan> plan;           ///< of the heights
  std::unique_ptr<ImageryMosaic> imagery;  ///< null where there are no images
  std::optional<TileTree> imagery_tree;

  /// The area of all sources.
  GeoBounds bounds() const;
};

/// Asks every source what it is, and lays out the trees of tiles.
Result<PackLayers> plan_layers(const BuildOptions& options, int threads);

}  // namespace cairn
