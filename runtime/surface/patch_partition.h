#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cairn/view_state.h"
#include "runtime/surface/patch_neighbours.h"
#include "runtime/surface/surface_patch.h"

namespace cairn {

/// For whom a surface is drawn, and how well.
struct SurfaceRules {
  ViewState view;
  double tolerance_px = 1;  ///< screen error of mesh and tiles together
  double lowest_m = 0;      ///< no ground of the scene is lower
  bool cull = true;         ///< what is certainly outside the picture or below the horizon is left out
};

struct PatchPartition {
  std::vector<SurfacePatch> patches;
  std::vector<SharedSegment> segments;
};

/// Returns the areas' patches, each with the coarsest triangulation that keeps the tolerance there.
///
/// A patch is split until one tolerance suits all of it, but not below 16 samples; until its cells are small
/// enough for the Earth's curvature; and until neighbours differ by kMaxLevelStep levels at most, so that the
/// larger one has a vertex where a smaller one ends. What overhangs the world is left out.
PatchPartition partition_areas(std::span<const SurfaceArea> areas, const SurfaceRules& rules);
inline constexpr int kMaxLevelStep = 4;

}  // namespace cairn
