#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "runtime/lod/mesh/lod_scene.h"
#include "runtime/lod/mesh/remove_t_junctions.h"
#include "runtime/lod/mesh/square_volumes.h"
#include "runtime/lod/mesh/tile_culling.h"
#include "runtime/lod/mesh/tile_window.h"
#include "runtime/view/cpu_clock.h"
#include "runtime/view/view_frustum.h"

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
void join_squares(const LodScene& scene, std::span<const GridSquare> squares, std::vector<LodTileMesh> meshes,
                  LodMesh& mesh);

/// Appends the grids of squares, watertight.
///
/// `vertex_at(window, square, i, j)` returns the vertex i columns and j rows of the grid from the south-west
/// corner. It may be moved along the grid, as far as the next vertex, so that triangles collapse; those are
/// left out. Corners of a square must stay. Diagonals run from south-west to north-east. REQUIRES: squares of
/// one tile are in sequence.
template <class VertexAt>
void append_squares(const LodScene& scene, std::span<const GridSquare> squares, const VertexAt& vertex_at,
                    LodMesh& mesh) {
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
  join_squares(scene, squares, std::move(meshes), mesh);
}

/// The squares of one tile's window that a view takes, as they are chosen from the whole window downwards. A
/// square of level k has 2^k cells a side; (x, y) counts squares of its level from the window's south-west
/// corner.
class TileSquares {
 public:
  /// Without a frustum, all squares are seen. Adds to `out`.
  TileSquares(const LodScene& scene, std::size_t number, const SquareVolumes& volumes,
              const ViewFrustum* frustum, std::vector<GridSquare>& out)
      : window_(scene, scene.tiles[number]),
        number_(number),
        volumes_(volumes),
        frustum_(frustum),
        out_(out) {}

  const TileWindow& window() const { return window_; }
  /// Returns the level of the whole window.
  int level() const { return std::bit_width(static_cast<unsigned>(window_.cells())) - 1; }
  /// Returns null for a square that is too small for a volume of its own.
  const BoundingVolume* volume_of(int k, int x, int y) const {
    if (k < volumes_.least()) return nullptr;
    return &volumes_.at(k, x + (window_.column() >> k), y + (window_.row() >> k)).volume;
  }
  /// Returns true, too, for a square without a volume.
  bool is_seen(int k, int x, int y) const {
    const BoundingVolume* volume = frustum_ ? volume_of(k, x, y) : nullptr;
    return volume == nullptr || frustum_->sees(*volume);
  }
  /// Takes a square with 2^step_level samples from vertex to vertex.
  void take(int k, int x, int y, int step_level) {
    out_.push_back({number_, x << k, y << k, 1 << k, 1 << step_level});
  }

 private:
  TileWindow window_;
  std::size_t number_;
  const SquareVolumes& volumes_;
  const ViewFrustum* frustum_;
  std::vector<GridSquare>& out_;
};

/// Builds the mesh of a view from squares, with its counts and times: volumes_of(tile) are a tile's
/// volumes, choose(TileSquares&) takes its squares, vertex_at is append_squares()' own.
template <class VolumesOf, class Choose, class VertexAt>
LodMesh build_of_squares(const LodScene& scene, const LodView& view, const VolumesOf& volumes_of,
                         const Choose& choose, const VertexAt& vertex_at) {
  const double start = thread_cpu_s();
  const ViewFrustum frustum(view.view, Occluder(scene.lowest_m, scene.ellipsoid));
  std::vector<GridSquare> squares;
  for (const std::size_t i : tiles_in_view(scene, view)) {
    TileSquares tile(scene, i, volumes_of(scene.tiles[i]), view.cull ? &frustum : nullptr, squares);
    choose(tile);
  }
  const double selected = thread_cpu_s();
  LodMesh mesh;
  append_squares(scene, squares, vertex_at, mesh);
  mesh.count(IndexForm::list, {3 * mesh.triangle_count(), squares.size()});
  mesh.selection_s = selected - start;
  mesh.building_s = thread_cpu_s() - selected;
  return mesh;
}

}  // namespace cairn
