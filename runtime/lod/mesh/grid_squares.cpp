#include "runtime/lod/mesh/grid_squares.h"

#include <unordered_map>

namespace cairn {
namespace {

/// Where tiles of different sources meet, each has its own height between the samples of the coarser one.
void take_finest_heights(const LodScene& scene, std::vector<LodTileMesh>& meshes) {
  struct Height {
    std::int64_t spacing;
    double height_m;
  };
  std::unordered_map<LatticePoint, Height> heights;
  const auto for_border = [&](auto use) {
    for (LodTileMesh& square : meshes) {
      const LodTile& tile = scene.tiles[square.tile];
      const LatticePoint low = south_west_of(tile.area);
      const std::int64_t width = lattice_width(tile.area.level), spacing = lattice_width(tile.source.level);
      for (LodVertex& v : square.vertices) {
        const std::int64_t x = v.point.x - low.x, y = v.point.y - low.y;
        if (x == 0 || y == 0 || x == width || y == width) use(spacing, v);
      }
    }
  };
  for_border([&](std::int64_t spacing, const LodVertex& v) {
    const auto [it, fresh] = heights.emplace(canonical(v.point), Height{spacing, v.height_m});
    Height& known = it->second;
    if (!fresh && (spacing < known.spacing || (spacing == known.spacing && v.height_m < known.height_m)))
      known = {spacing, v.height_m};
  });
  for_border([&](std::int64_t, LodVertex& v) { v.height_m = heights.at(canonical(v.point)).height_m; });
}

void append(const LodTileMesh& square, LodMesh& mesh) {
  if (mesh.tiles.empty() || mesh.tiles.back().tile != square.tile)
    mesh.tiles.push_back({square.tile, {}, {}});
  LodTileMesh& out = mesh.tiles.back();
  const auto first = static_cast<std::uint32_t>(out.vertices.size());
  out.vertices.insert(out.vertices.end(), square.vertices.begin(), square.vertices.end());
  for (const LodTriangle& t : square.triangles)
    out.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

}  // namespace

void join_squares(const LodScene& scene, std::span<const GridSquare> squares, std::vector<LodTileMesh> meshes,
                  LodMesh& mesh) {
  take_finest_heights(scene, meshes);
  std::vector<MeshArea> areas;
  areas.reserve(squares.size());
  for (const GridSquare& square : squares) {
    const TileWindow window(scene, scene.tiles[square.tile]);
    areas.push_back({window.point(square.column, square.row), square.cells * window.spacing()});
  }
  split_at_borders(areas, meshes);
  for (const LodTileMesh& square : meshes) append(square, mesh);
}

}  // namespace cairn
