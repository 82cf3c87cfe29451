#pragma once

#include <vector>

#include "cairn/height_tile.h"
#include "cairn/tile_id.h"

namespace cairn {

/// bisection_errors() in metres, of the tile `id`. `between_samples`: where the tile stands for finer ones,
/// whose samples lie between its own, a triangle is also held against the tile's bilinear surface, of which
/// the tile's own error speaks. It differs from that by more than at the samples only in the cells that its
/// diagonal edges cut: such an edge counts at the vertex that bisects it, the centre of its square. What the
/// diagonal of a single cell is off by, a quarter of its twist, no vertex can mend, and is left out.
std::vector<float> vertex_errors_m(const HeightTile& heights, const TileId& id, double quantum_m,
                                   bool between_samples);

/// How far a flat triangle with legs of one cell along the grid, whose hypotenuse runs across, is from the
/// curved Earth, at most, where it is level: |∂²P|ρ²/2, ρ = cell/√2 the radius of its circumcircle and
/// |∂²P| <= 2/√3 (R+h) the second derivative of the position along any direction of the grid, largest near
/// the poles, where the ellipsoid's radius of curvature, R, is largest too: a²/b. It grows with the square of
/// the legs; a triangle whose hypotenuse runs along the grid and is as long as these legs has half of it.
double chord_of_cell_m(double cell_radians, double highest_m);

}  // namespace cairn
