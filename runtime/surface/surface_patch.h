#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "cairn/tile_id.h"
#include "runtime/surface/surface_tile.h"

namespace cairn {

/// An area to draw, and whose heights it shows.
struct SurfaceArea {
  TileId area;
  const SurfaceTile* surface = nullptr;  ///< of the area or an ancestor; null: height 0 everywhere
  double detail = kMaxLevel;             ///< the surface is shown with: ShownSurface::of()
  bool moves = false;                    ///< its detail changes from frame to frame: its mesh keeps half
                                         ///< the tolerance
  double error_m = 0;                    ///< how far finer heights may lie from the tile's own surface: the
                                         ///< mesh leaves room for it
  double reach_m = 0;  ///< how far objects reach from their feet: ground so near the picture counts as seen
};

/// The most cells along a patch's side, log2: what one patch draws.
inline constexpr int kPatchCellsLog2 = 6;

/// A square part of an area that is drawn as one triangulation, on a lattice of 2^cells_log2 cells a side.
struct SurfacePatch {
  TileId area;
  std::size_t from = 0;  ///< which of the SurfaceAreas
  ShownSurface surface;
  int cells_log2 = 0;
  int step = 0;         ///< of the tile's VertexSteps
  int forced_log2 = 0;  ///< every vertex is there whose distance to the next of its kind is 2^-forced_log2 of
                        ///< a side or more: what the body's curvature asks for
  Ellipsoid ellipsoid = {};
  double distance_m = 0;  ///< from the eye to its ground, at least

  int cells() const { return 1 << cells_log2; }
  /// log2 of the tile's own cells along a side; negative where the patch is a part of a cell.
  int sample_cells_log2() const {
    return surface.tile ? surface.tile->id.level + cells_log2_of(surface.tile->heights->size) - area.level
                        : 0;
  }
};

enum class Side { south, north, west, east };
inline constexpr std::array kSides{Side::south, Side::north, Side::west, Side::east};
inline bool is_vertical(Side side) {
  return side == Side::west || side == Side::east;
}
inline Side opposite(Side side) {
  switch (side) {
    case Side::south:
      return Side::north;
    case Side::north:
      return Side::south;
    case Side::west:
      return Side::east;
    default:
      return Side::west;
  }
}

/// Which lattice vertices of a patch's sides are drawn, by side: bit i is the i-th from the west or the
/// south, 0 < i < cells. The corners always are.
using SideVertices = std::array<std::uint64_t, 4>;
inline std::uint64_t& of_side(SideVertices& sides, Side side) {
  return sides[static_cast<std::size_t>(side)];
}
inline std::uint64_t of_side(const SideVertices& sides, Side side) {
  return sides[static_cast<std::size_t>(side)];
}

}  // namespace cairn
