#pragma once

#include "builder/export/quantized_mesh_file.h"
#include "builder/export/quantized_mesh_plan.h"
#include "builder/export/quantized_mesh_source.h"
#include "cairn/status.h"

namespace cairn {

/// Returns the tile with its measured error in `error_m`: no source post in it is farther from the mesh,
/// vertically and as decoded, as far as the pack knows them; what the Earth's curvature takes off the middle
/// of the largest triangle is added. It is above plan.bound_m() only where more vertices do not help. The
/// tile depends on the source alone, and any number of threads may call this.
Result<QuantizedMesh> make_quantized_mesh(const QuantizedMeshSource& source, const GeographicTile& tile);

}  // namespace cairn
