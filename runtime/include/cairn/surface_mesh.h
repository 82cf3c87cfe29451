#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec3.hpp>

#include "cairn/tile_id.h"

namespace cairn {

/// A vertex of the surface, as a vertex buffer takes it. Vertices that patches share have equal bits in each
/// of them, so that nothing gapes.
///
/// Its place is geocentric, in metres, the sum of two floats. With the eye split likewise,
/// (high − eye_high) + (low − eye_low) is exact to a ten-millionth of the distance in single precision, and
/// equal for equal vertices. While tiles are exchanged the ground glides: the vertex is drawn
/// to_coarser_m · SurfaceDraw::coarser_share above that place, along the ellipsoid's normal.
struct SurfaceVertex {
  glm::vec3 high{0};
  glm::vec3 low{0};
  float height_m = 0;      ///< in the pack's vertical datum
  float to_coarser_m = 0;  ///< the coarser level's height less this
  std::uint16_t east = 0;  ///< in the patch, in units of 1 / kSurfaceSide, from its south-west corner
  std::uint16_t north = 0;
};
static_assert(sizeof(SurfaceVertex) == 36);
inline constexpr int kSurfaceSide = 1 << 15;

/// One patch to draw: triangles of 16-bit indices, relative to first_vertex, counter-clockwise from above.
struct SurfaceDraw {
  TileId area;              ///< of the patch
  std::uint32_t tile = 0;   ///< whose heights and imagery it shows: a number in the frame's list
  float coarser_share = 0;  ///< 0…1, see SurfaceVertex
  std::uint32_t first_vertex = 0;
  std::uint32_t first_index = 0;
  std::uint32_t index_count = 0;
};

/// What a frame's buffers need before it is drawn: ranges that no earlier draw of the frame uses.
struct SurfaceUpload {
  std::uint32_t first_vertex = 0;
  std::uint32_t first_index = 0;
  std::vector<SurfaceVertex> vertices;
  std::vector<std::uint16_t> indices;
};

/// A vertex of a wall between two rims.
struct SurfaceWallVertex {
  SurfaceVertex vertex;        ///< placed in the patch `shown_as`
  std::uint32_t patch = 0;     ///< the draw whose coarser_share it glides by
  std::uint32_t shown_as = 0;  ///< the draw whose colours it has
};
static_assert(sizeof(SurfaceWallVertex) == 44);

/// The upright triangles of a frame, either way round.
struct SurfaceWalls {
  std::vector<SurfaceWallVertex> vertices;
  std::vector<std::uint32_t> indices;
};

/// The surface of one frame: a host keeps one buffer of vertices and one of indices from frame to frame,
/// makes room up to the two ends (keeping what is there), copies the uploads in, and draws.
struct SurfaceMesh {
  std::vector<SurfaceUpload> uploads;
  std::vector<SurfaceDraw> draws;
  SurfaceWalls walls;
  std::uint32_t vertex_end = 0;
  std::uint32_t index_end = 0;
  std::uint64_t triangles = 0;  ///< walls included
};

}  // namespace cairn
