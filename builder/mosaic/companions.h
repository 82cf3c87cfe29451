#pragma once

#include "builder/raster/raster_pool.h"
#include "cairn/status.h"

namespace cairn {

/// bad_data where sources are companions of another one, not heights: rasters that a product lays on its
/// DEM's own grid, such as counts, masks, errors or dates. They are known by the ending of their name beside
/// that DEM's, or by their posts: few distinct small whole numbers where the DEM's are many. The error lists
/// all of them.
Status refuse_companions(RasterPool& pool);

}  // namespace cairn
