#pragma once

#include <filesystem>
#include <optional>

#include "cairn/body.h"
#include "cairn/status.h"
#include "runtime/lod/lod_method.h"

namespace cairn {

/// Writes a mesh as .obj or .ply (ASCII), equal vertices once. Each vertex is longitude and latitude in
/// degrees and height in metres, or with the ellipsoid `ecef` geocentric metres, with enough digits to read
/// back the same double. Longitudes of the antimeridian are -180. The error is usage if the file's ending is
/// neither.
Status write_mesh(const LodMesh& mesh, const std::filesystem::path& path,
                  const std::optional<Ellipsoid>& ecef = std::nullopt);

}  // namespace cairn
