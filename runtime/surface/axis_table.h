#pragma once

#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include "cairn/tile_id.h"

namespace cairn::gl {

/// With λ and φ the longitude and latitude of a column and a row of samples, N the radius of curvature in the
/// prime vertical, and h the height above the ellipsoid (WGS84, metres), geocentric positions are
///   x = (N cosφ + h cosφ) cosλ,  y = (N cosφ + h cosφ) sinλ,  z = N(1−e²) sinφ + h sinφ,
/// so that a vertex is a few double-precision products of a column's and a row's entry. Equal longitudes
/// and latitudes give equal entries in every tile, and ±180° are the same longitude: vertices that tiles
/// share are bit-identical. (See any geodesy text, e.g. Snyder 1987, §3.)
using ColumnEntry = glm::dvec2;  ///< cosλ, sinλ
using RowEntry = glm::dvec4;     ///< N cosφ, cosφ, N(1−e²) sinφ, sinφ

/// The entries of all columns (rows) of samples of the tiles of a level in column x (row y) of the grid.
/// Beyond 180°E (90°N) they repeat the last in the world.
std::vector<ColumnEntry> column_table(int level, std::int32_t x, int tile_size);
std::vector<RowEntry> row_table(int level, std::int32_t y, int tile_size);

}  // namespace cairn::gl
