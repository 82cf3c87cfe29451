#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "builder/export/geodesy.h"

namespace cairn {

/// One mesh in metres as a binary glTF 2.0 file: geocentric ones (EPSG:4978), or east, north and up on a
/// plane.
struct GlbMesh {
  std::vector<Vector3> positions;
  std::vector<Vector3> normals;               ///< unit vectors, one a position
  std::vector<std::array<float, 2>> texture;  ///< from the image's west and NORTH; empty without an image
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< anticlockwise seen from above
  std::vector<std::byte> jpeg;                          ///< the image; empty where there is none
  std::string about;  ///< JSON that the file's asset has as `extras`; empty for none
};

/// The file. Positions are single precision relative to their middle, which the node's translation has.
/// glTF's y axis is up: (x, y, z) is written as (x, z, -y), which 3D Tiles turns back.
std::vector<std::byte> encode_glb(const GlbMesh& mesh);

}  // namespace cairn
