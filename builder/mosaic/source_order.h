#pragma once

#include <memory>
#include <vector>

#include "builder/mosaic/source_group.h"
#include "builder/raster/raster_pool.h"

namespace cairn {

/// Puts groups into the order in which they win: by what the user says of their priority, then those of finer
/// posts first, then by the order of their first sources. Spacings count on the ground, the longer
/// axis's; those within 5 % of one another are equal, so that between two UTM zones the order of the command
/// line decides.
void sort_by_priority(const RasterPool& pool, std::vector<std::unique_ptr<SourceGroup>>& groups);

}  // namespace cairn
