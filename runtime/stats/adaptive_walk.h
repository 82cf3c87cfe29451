#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "cairn/pack_reader.h"
#include "runtime/stats/block_count.h"
#include "runtime/stats/walk.h"

namespace cairn {

/// What a walk's eyes see, and how good it has to be.
struct AdaptiveSpec {
  TileId start;    ///< the eye's tile before the first move, with heights of the pack
  int levels = 4;  ///< K: coarser tiles than the finest K levels are not counted
  double tolerance_px = 1;
  std::uint64_t budget_bytes = 0;  ///< of decoded tiles; 0: none
};

/// What the runtime selects for each eye of a walk, the start first.
struct AdaptiveWalk {
  std::vector<std::vector<TileId>> tiles;  ///< of the counted levels: ascending, each once
  double error_px = 0;                     ///< the largest screen error of the heights in any of the views
};

/// Selects tiles by error as a Terrain does, with its ring and its hysteresis: for a view of 1920×1080 pixels
/// and 60° whose eye stands over the middle of its tile, so high that a sample straight below is a pixel, and
/// looks 10° down in the direction of the move.
AdaptiveWalk walk_adaptively(const AdaptiveSpec& spec, std::span<const Move> walk,
                             const std::shared_ptr<const PackReader>& pack);

}  // namespace cairn
