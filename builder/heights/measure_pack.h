#pragma once

#include "builder/heights/error_stats.h"
#include "cairn/grid_options.h"
#include "cairn/height_options.h"
#include "cairn/mosaic_options.h"
#include "cairn/pack_reader.h"
#include "cairn/progress.h"
#include "cairn/session_options.h"
#include "cairn/status.h"

namespace cairn {

/// Measures a pack anew against its sources: every post that won, against the bilinear surface of the finest
/// tile, decoded from the pack, that covers it. REQUIRES: options as the bake had them; of the session's only
/// memory and threads count. Uses all threads of the caller's arena. `progress` counts samples of the finest
/// tiles, and ends the work where it says so.
Result<ErrorStats> measure_pack(const PackReader& pack, const MosaicOptions& asked,
                                const HeightOptions& heights, const GridOptions& grid,
                                const SessionOptions& session, const ProgressCallback& progress);

}  // namespace cairn
