#pragma once

#include <cstddef>
#include <functional>

#include "builder/export/glb_writer.h"
#include "builder/export/local_plane.h"
#include "builder/export/region_raster.h"
#include "cairn/status.h"

namespace cairn {

/// Coordinates may be rounded to this step when they are written.
inline constexpr double kMeshStep_m = 0.001;

/// A raster as triangles on a plane.
struct MeshedRegion {
  GlbMesh ground;          ///< metres to the east and the north and above the datum; no image
  double max_error_m = 0;  ///< the raster's own error included
};

/// Meshes the raster so that no point of the ground is farther from the triangles than the bound, along the
/// vertical and with coordinates that are rounded to kMeshStep_m or to single precision. The mesh's edge is
/// the raster's; cells with a void corner are left out. failed where the bound cannot be kept or `go_on`
/// returns an error, usage where more than `most_vertices` were needed.
Result<MeshedRegion> mesh_region(const RegionRaster& raster, const LocalPlane& plane, double bound_m,
                                 std::size_t most_vertices, const std::function<Status()>& go_on);

}  // namespace cairn
