#pragma once

#include <filesystem>

#include "cairn/status.h"
#include "runtime/lod/lod_method.h"

namespace cairn {

/// Writes a mesh as .obj or .ply (ASCII), vertices that are the same once. Each vertex is longitude, latitude
/// in degrees and height in metres, or with `ecef` geocentric metres, in the digits that read back as the
/// same double. Longitudes of the antimeridian are -180. usage where the ending is neither.
Status write_mesh(const LodMesh& mesh, const std::filesystem::path& path, bool ecef);

}  // namespace cairn
