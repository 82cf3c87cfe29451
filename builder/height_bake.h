#pragma once

#include <cstdint>
#include <vector>

#include "builder/baked_tile.h"
#include "builder/build_plan.h"
#include "builder/journal.h"
#include "builder/mosaic.h"
#include "builder/progress.h"
#include "format/pack_writer.h"
#include "format/status.h"

namespace cairn {

/// What the heights layer turned out to be.
struct HeightSummary {
  PostStats accuracy;
  std::vector<std::uint64_t> posts_won;  ///< by source
  std::uint64_t samples = 0;             ///< of all tiles made, stored or not
};

/// Makes every height tile of the plan and adds it to the pack. Units whose records are given were done
/// before an interruption: their blocks are in the pack already. Uses all threads of the caller's arena.
Result<HeightSummary> bake_heights(const Mosaic& mosaic, const BuildPlan& plan, VoidMode voids, int threads,
                                   std::vector<UnitRecord> done, PackWriter& writer, Journal& journal,
                                   const ProgressCallback& progress);

}  // namespace cairn
