#pragma once

#include <memory>
#include <vector>

#include "builder/mosaic/geoid.h"
#include "builder/mosaic/source_group.h"
#include "builder/raster/io/chunk_cache.h"
#include "builder/raster/raster_pool.h"
#include "cairn/mosaic_options.h"

namespace cairn {

/// Sorts the sources into groups that are resampled together, highest priority first: finer posts before
/// coarser ones, then by the order on the command line of the group's first source. `blocks`: where projected
/// groups keep what they resampled. REQUIRES: pool and geoid (may be null) outlive the
/// groups.
Result<std::vector<std::unique_ptr<SourceGroup>>> group_sources(RasterPool& pool, const Geoid* geoid,
                                                                const MosaicOptions& options, int tile_size,
                                                                std::shared_ptr<ChunkCache> blocks);

}  // namespace cairn
