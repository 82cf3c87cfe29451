#pragma once

#include "builder/bake/bake_session.h"
#include "cairn/progress.h"
#include "cairn/status.h"

namespace cairn {

/// How many triangulations a tile gets, each with twice the tolerance of the one before.
inline constexpr int kRqtSteps = 8;

struct RqtPlan {
  int tile_size = 513;
  double quantum_m = 0.25;
  int finest = 0;         ///< the level whose tiles get the tolerance; each coarser one gets twice that
  float tolerance_m = 1;  ///< > 0
};

/// Adds the rqt layer: for each height tile of the pack its triangulations, see RqtSteps, with equal vertices
/// on both sides of every edge that tiles of one level have in common (RqtBorders).
///
/// The heights are read back from the session's writer. A level at a time, the coarsest first: every tile for
/// itself, then, once the borders agree, every tile again as a tile layer of its own, so that borders are
/// kept in memory and no tiles. REQUIRES: all heights are in the session's writer.
Status bake_rqt_layers(const RqtPlan& plan, int threads, BakeSession& session,
                       const ProgressCallback& progress);

}  // namespace cairn
