#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/remove_t_junctions.h"
#include "runtime/lod/mesh/tile_window.h"

namespace cairn {

/// A square of a tile's window that is drawn as a regular grid of vertices.
struct GridSquare {
  std::size_t tile = 0;  ///< in the scene
  int column = 0;        ///< its south-west sample, in the tile's window
  int row = 0;
  int cells = 1;  ///< of the window along a side; a power of two, as step
  int step = 1;   ///< samples from one vertex to the next

  int across() const { return cells / step; }  ///< cells of the grid along a side
};

/// Joins the meshes of squares, each made by itself, to one of each tile. Heights on the tiles' borders
/// become those of the finest source, and triangles are split where a square beside theirs has more vertices.
/// Returns the number of triangles that the splits added.
std::size_t join_squares(const LodScene& scene, std::span<const GridSquare> squares,
                         std::vector<LodTileMesh> meshes, LodMesh& mesh);

/// Appends the grids of squares, watertight, and returns what join_squares() does.
///
/// `vertex_at(window, square, i, j)` returns the vertex i columns and j rows of the grid from the south-west
/// corner. It may be moved along the grid, as far as the next vertex, so that triangles collapse; those are
/// left out. Corners of a square must stay. Diagonals run from south-west to north-east. REQUIRES: squares of
/// one tile are in sequence.
template <class VertexAt>
std::size_t append_squares(const LodScene& scene, std::span<const GridSquare> squares,
                           const VertexAt& vertex_at, LodMesh& mesh) {
  std::vector<LodTileMesh> meshes;
  meshes.reserve(squares.size());
  for (const GridSquare& square : squares) {
    const TileWindow window(scene, scene.tiles[square.tile]);
    LodTileMesh& out = meshes.emplace_back(LodTileMesh{square.tile, {}, {}});
    const int n = square.across();
    out.vertices.reserve(static_cast<std::size_t>(n + 1) * static_cast<std::size_t>(n + 1));
    out.triangles.reserve(2 * static_cast<std::size_t>(n) * static_cast<std::size_t>(n));
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) out.vertices.push_back(vertex_at(window, square, i, j));
    }
    const auto add = [&](const LodTriangle& t) {
      const LatticePoint &a = out.vertices[t[0]].point, &b = out.vertices[t[1]].point,
                         &c = out.vertices[t[2]].point;
      if (a != b && b != c && a != c) out.triangles.push_back(t);
    };
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const auto sw = static_cast<std::uint32_t>(j * (n + 1) + i),
                   nw = sw + static_cast<std::uint32_t>(n) + 1;
        add({sw, sw + 1, nw + 1});
        add({sw, nw + 1, nw});
      }
    }
  }
  return join_squares(scene, squares, std::move(meshes), mesh);
}

}  // namespace cairn
