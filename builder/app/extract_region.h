#pragma once

#include <optional>

#include "builder/app/bake_progress.h"
#include "builder/export/height_image.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// What is extracted of a pack beyond one stored tile: posts on a grid, drawn from the tiles of a level.
struct RegionPlan {
  HeightGrid grid;
  int level = 0;
};

/// Posts on the samples of a level that lie in the region, so that heights come as they are stored. Without a
/// level, that of the region's finest tiles. Wrong usage where no sample lies in the region.
Result<RegionPlan> plan_samples(const PackReader& pack, const GeoBounds& region, std::optional<int> level);

/// Posts from the region's north-western corner on, `spacing` degrees apart, drawn from the coarsest level
/// that is as dense.
Result<RegionPlan> plan_spacing(const PackReader& pack, const GeoBounds& region, double spacing);

/// The posts of a .hgt cell, which is the region: 3601 along a side where the pack has samples that are
/// more than 2400 per degree, else 1201. Wrong usage where the region is no cell.
Result<RegionPlan> plan_cell(const PackReader& pack, const GeoBounds& region);

/// The plan's heights as rows. REQUIRES: pack and plan outlive the rows.
HeightRows rows_of(const PackReader& pack, const RegionPlan& plan, BakeProgress& progress);

}  // namespace cairn
