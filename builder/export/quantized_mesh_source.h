#pragma once

#include "builder/export/metre_tiles.h"
#include "builder/export/pack_patches.h"
#include "builder/export/quantized_mesh_plan.h"
#include "builder/export/vertical_shift.h"

namespace cairn {

/// What the tiles of a quantized-mesh export are made from.
struct QuantizedMeshSource {
  const QuantizedMeshPlan& plan;
  const PackPatches& patches;
  MetreTiles& tiles;
  const VerticalShift& shift;
};

}  // namespace cairn
