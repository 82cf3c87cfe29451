#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "builder/export/geodesy.h"
#include "builder/export/tile_ranges.h"

namespace cairn {

/// A tile as quantized-mesh 1.0 holds it (CesiumGS/quantized-mesh, README).
struct QuantizedMesh {
  static constexpr int kLargest = 32767;

  GeoBounds bounds;
  Ellipsoid ellipsoid;
  float lowest_m = 0;                       ///< the height that 0 stands for
  float highest_m = 0;                      ///< the height that kLargest stands for
  std::vector<std::uint16_t> u, v, height;  ///< of the vertices: from the west, the south, the lowest
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< anticlockwise seen from above
  std::vector<Vector3> normals;                         ///< geocentric unit vectors, one a vertex
  std::vector<std::uint8_t> has_ground;                 ///< 0 where the pack has no height, one a vertex
  double error_m = 0;                                   ///< goes into the metadata extension
  /// Which tiles there are below this one, a list a level from the next one on, likewise there.
  std::vector<std::vector<TileRange>> available;

  double metres(std::size_t vertex) const;
  LonLat place(std::size_t vertex) const;
};

/// The bytes of the tile with the extensions of oct-encoded normals and metadata. Vertices are renumbered by
/// their first use, in an order of triangles that is near in space.
std::vector<std::byte> encode_quantized_mesh(const QuantizedMesh& mesh);

}  // namespace cairn
