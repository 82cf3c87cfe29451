#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include "cairn/tile_id.h"
#include "runtime/surface/surface_tile.h"

namespace cairn::gl {

/// An area to draw, and whose heights it shows.
struct MeshArea {
  TileId area;
  const SurfaceTile* surface = nullptr;  ///< of the area or an ancestor; null: height 0 everywhere
  double distance_m = 0;                 ///< from the eye to the nearest point of the area, or less
  double detail = kMaxLevel;             ///< the surface is shown with: ShownSurface::of()
  bool moves = false;  ///< its detail changes from frame to frame: the grids keep half the tolerance
};

/// A regular grid of vertices over an area or over a part of it. Vertex (i, j) is i columns from the west and
/// j rows from the south.
struct GridPatch {
  TileId area;
  std::size_t from = 0;  ///< which of the MeshAreas
  int cells_log2 = 0;    ///< a whole side has 2^cells_log2 cells
  int cells_east = 0;    ///< up to the end of the world: less than 2^cells_log2 only in overhanging tiles
  int cells_north = 0;
  unsigned listed_sides =
      0;  ///< bits: 1 south, 2 north, 4 west, 8 east; the others are the patch's own samples
  std::size_t perimeter = 0;  ///< the first entry of the listed sides in MeshPlan::perimeter

  int cells() const { return 1 << cells_log2; }
};

/// Where a vertex of a listed side is drawn: on a vertex of the same side that the neighbour has too, at the
/// height that the neighbour uses too. A side of n cells has n+1 entries, from the west or the south; the
/// listed sides of a patch follow each other in the order of their bits.
struct PerimeterVertex {
  std::uint16_t column = 0;
  std::uint16_t row = 0;
  float height_m = 0;  ///< NaN: void
};

/// A vertex of a wall: at a vertex of a grid, at another height, or at the grid's own.
struct WallVertex {
  std::uint32_t patch = 0;     ///< whose grid `at` is a vertex of, in MeshPlan::patches
  std::uint32_t shown_as = 0;  ///< the patch whose colours it has
  PerimeterVertex at;
  glm::vec2 place{0};  ///< in that patch, 0…1 from its south-west corner
};

struct MeshPlan {
  std::vector<GridPatch> patches;
  std::vector<PerimeterVertex> perimeter;
  std::vector<WallVertex> wall_vertices;
  std::vector<std::array<std::uint32_t, 3>> wall_triangles;  ///< either way round
};

struct MeshRules {
  int tile_size = 513;
  double pixels_per_radian = 1000;  ///< picture height / (2 tan(fov / 2))
  double tolerance_px = 1;          ///< screen error that the mesh may add to the tiles' own
  glm::dvec3 eye{};                 ///< geocentric, metres
  std::vector<glm::dvec3> inward;   ///< normals of planes through the eye; what is behind one is left out
};

/// Chooses how many samples of each area are drawn, and joins the grids without cracks.
///
/// Each patch takes the coarsest grid whose deviation, that of the decimated heights plus that of the chords
/// from the Earth's curvature, is at most the tolerance as seen from the eye; an area
/// that needs more cells than a block has is split, so that its near parts get finer grids than its far ones.
/// Two patches that touch along a segment and show equal detail draw it with the vertices of the coarser of
/// their grids: the finer grid's other vertices on it move onto those, so that no vertex of one lies on an
/// edge of the other. (De Boer 2000 leaves vertices out likewise; here it is done for any two grids.) Samples
/// nest, so that both read equal heights; where a patch is too small to have a sample of the shown level at
/// its corners, all of that detail that touch the point take the height that the coarsest tile gives. Patches
/// whose levels differ by more than kMaxLevelStep are split, so that the coarser has a vertex where a finer
/// one ends.
///
/// Where the two sides show different detail, or one has no heights, each keeps its own rim, and a wall fills
/// what gapes between them: vertical triangles that have every edge of the one rim and every edge of the
/// other. Where all tiles are there that the eye asks for, a wall is as high as a tile's error: what the eye
/// allows. It is a cliff where a source ends.
///
/// So what is drawn at a place is its area's surface and nobody else's, with the detail of the grid or of the
/// area, whichever is less, and when grids change between two frames, no place moves by more than the
/// tolerance: the deviations that are compared with it are sums over the steps from the finest detail. Of
/// what else moves a place, an area that `moves`, half is left.
///
/// REQUIRES: no two areas overlap; every surface has rules.tile_size samples a side.
MeshPlan plan_mesh(std::span<const MeshArea> areas, const MeshRules& rules);
inline constexpr int kMaxLevelStep = 4;

}  // namespace cairn::gl
