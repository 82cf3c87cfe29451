#include "runtime/viewer/method_mesh.h"

#include <algorithm>
#include <cstddef>

#include "cairn/geodesy.h"

namespace cairn::viewer {
namespace {

SurfaceWallVertex vertex_of(const LodVertex& vertex, std::size_t tile, const TileId& area,
                            const Ellipsoid& ellipsoid) {
  const LatticePoint corner = south_west_of(area);
  const std::int64_t width = lattice_width(area.level);
  LonLat place = place_of(vertex.point);
  if (place.lon == 180) place.lon = -180;  // so that both sides of the antimeridian have the same bits
  const glm::dvec3 position = to_geocentric(place, vertex.height_m, ellipsoid);
  const glm::vec3 high(position);
  const auto part = [&](std::int64_t from, std::int64_t to) {
    return static_cast<std::uint16_t>((to - from) * kSurfaceSide / width);
  };
  const auto number = static_cast<std::uint32_t>(tile);
  return {{high, glm::vec3(position - glm::dvec3(high)), static_cast<float>(vertex.height_m), 0,
           part(corner.x, vertex.point.x), part(corner.y, vertex.point.y)},
          number,
          number};
}

bool has(const TileId& area, const LatticePoint& point) {
  const LatticePoint corner = south_west_of(area);
  const std::int64_t width = lattice_width(area.level);
  return point.x >= corner.x && point.x <= corner.x + width && point.y >= corner.y &&
         point.y <= corner.y + width;
}

/// Walls belong to no tile: each triangle has the colours of one whose side it stands on.
void append_walls(const LodTileMesh& walls, const LodScene& scene, SurfaceWalls& out) {
  for (const LodTriangle& triangle : walls.triangles) {
    for (std::size_t i = 0; i < scene.tiles.size(); ++i) {
      const TileId& area = scene.tiles[i].area;
      if (!std::all_of(triangle.begin(), triangle.end(),
                       [&](std::uint32_t corner) { return has(area, walls.vertices[corner].point); }))
        continue;
      for (const std::uint32_t corner : triangle) {
        out.indices.push_back(static_cast<std::uint32_t>(out.vertices.size()));
        out.vertices.push_back(vertex_of(walls.vertices[corner], i, area, scene.ellipsoid));
      }
      break;
    }
  }
}

}  // namespace

SurfaceWalls vertices_of(const LodMesh& mesh, const LodScene& scene) {
  SurfaceWalls out;
  for (const LodTileMesh& part : mesh.tiles) {
    const auto first = static_cast<std::uint32_t>(out.vertices.size());
    const TileId& area = scene.tiles[part.tile].area;
    for (const LodVertex& vertex : part.vertices)
      out.vertices.push_back(vertex_of(vertex, part.tile, area, scene.ellipsoid));
    for (const LodTriangle& triangle : part.triangles) {
      for (const std::uint32_t corner : triangle) out.indices.push_back(first + corner);
    }
  }
  append_walls(mesh.walls, scene, out);
  return out;
}

}  // namespace cairn::viewer
