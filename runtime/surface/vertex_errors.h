#pragma once

#include <vector>

#include "cairn/body.h"
#include "cairn/height_tile.h"
#include "cairn/tile_id.h"

namespace cairn {

/// Returns, by sample, the largest distance in metres of samples from the two triangles bisected there.
///
/// It is bisection_errors() of the tile `id`, in metres. `between_samples` is for a tile that stands for
/// finer ones, whose samples lie between its own: triangles are then measured against the tile's bilinear
/// surface too, to which the tile's own error refers. A triangle's distance from that surface is larger than
/// at the samples only in the cells that its diagonal edges cut; such an edge counts at the vertex that
/// bisects it, the centre of its square. The distance along the diagonal of a single cell, a quarter of its
/// twist, is left out, because no vertex bisects it.
std::vector<float> vertex_errors_m(const HeightTile& heights, const TileId& id, double quantum_m,
                                   bool between_samples);

/// Returns the largest distance, in metres, between the curved Earth and a level flat triangle of one cell.
///
/// The triangle has legs of one cell along the grid and a diagonal hypotenuse. The distance is at most
/// |∂²P|ρ²/2, where ρ = cell/√2 is the radius of the triangle's circumcircle and |∂²P| <= 2/√3 (R+h) the
/// second derivative of the position along any direction of the grid. It is largest near the poles, where the
/// ellipsoid's radius of curvature R is largest too, a²/b. The distance grows with the square of the legs; a
/// triangle whose hypotenuse runs along the grid and is as long as these legs has half of it.
double sagitta_of_cell_m(double cell_radians, double highest_m, const Ellipsoid& ellipsoid);

}  // namespace cairn
