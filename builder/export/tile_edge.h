#pragma once

#include <cstdint>
#include <vector>

#include "builder/export/quantized_mesh_source.h"
#include "cairn/status.h"

namespace cairn {

enum class TileSide { west, south, east, north };

/// The vertices of a tile's edge, from the west or the south, corners included. They depend on the edge
/// alone: the tile on its other side gets the same ones.
struct TileEdge {
  struct Vertex {
    std::int64_t along = 0;  ///< ticks
    double metres = 0;       ///< of the export, a multiple of the level's step
  };
  std::vector<Vertex> vertices;
  int order = 0;  ///< of the lattice that they lie on
};
Result<TileEdge> tile_edge(const QuantizedMeshSource& source, const GeographicTile& tile, TileSide side);

/// The lattice on which a patch is looked at, and what the ground is off the surface of its samples.
struct PatchLattice {
  int order = 0;
  double error_m = 0;
};
PatchLattice lattice_of(const QuantizedMeshSource& source, const Patch& patch, int level, double wanted_m);

/// The share of a tile's bound that the surface which the mesh is made from may be off.
inline constexpr double kSurfaceShare = 0.25;

/// The finest order that vertices may have: their places are rounded to 1/32767 of a tile.
inline constexpr int kMostOrder = 8;

/// Every tile has at least the vertices of a grid of so many squares a side, which divides 45: what the
/// body's curvature takes off a square is about a quarter of the bound.
int base_squares(int level, double bound_m, const Ellipsoid& ellipsoid);

/// Rounded to the level's step.
double rounded_height(const QuantizedMeshSource& source, double metres, int level);

}  // namespace cairn
