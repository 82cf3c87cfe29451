#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include "builder/bake/tile_tree.h"
#include "builder/heights/height_plan.h"
#include "builder/imagery/imagery_mosaic.h"
#include "builder/mosaic/mosaic.h"
#include "cairn/body.h"
#include "cairn/build_options.h"

namespace cairn {

/// What a bake makes a pack of: heights, imagery or both.
struct BakePlan {
  std::unique_ptr<Mosaic> heights;         ///< null where there are no DEMs
  std::optional<HeightPlan> plan;          ///< of the heights
  std::unique_ptr<ImageryMosaic> imagery;  ///< null where there are no images
  std::optional<TileTree> imagery_tree;
  Body body;  ///< of all sources

  /// The area of all sources.
  GeoBounds bounds() const;
};

/// Every file that a bake reads: DEMs, images, the geoid, places of objects, models and their textures.
std::vector<std::filesystem::path> files_of(const BuildOptions& options);

/// Asks every source what it is, and lays out the trees of tiles.
Result<BakePlan> plan_bake(const BuildOptions& options, int threads);

/// Sources that were looked at before. Those that are not available are not read.
struct KnownSources {
  std::vector<RasterInfo> dems;
  std::vector<RasterInfo> images;
  std::vector<bool> dems_available;    ///< by DEM; empty where all are
  std::vector<bool> images_available;  ///< likewise
  bool geoid_available = true;
};

/// plan_bake() of sources that are known: `options.mosaic.inputs` and `options.imagery.inputs` are theirs.
Result<BakePlan> plan_bake(KnownSources sources, const BuildOptions& options, int threads);

}  // namespace cairn
