#pragma once

#include <cstdint>
#include <vector>

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "cairn/body.h"
#include "cairn/tile_id.h"

namespace cairn {

/// With λ and φ the longitude and latitude of a column and a row of samples, N the radius of curvature in the
/// prime vertical, and h the height above the ellipsoid (metres), geocentric positions are
///   x = (N cosφ + h cosφ) cosλ,  y = (N cosφ + h cosφ) sinλ,  z = N(1−e²) sinφ + h sinφ,
/// so that a vertex is a few products of a column's and a row's entry. Equal longitudes and latitudes give
/// equal entries in every tile, and ±180° are the same longitude: vertices that tiles share are
/// bit-identical. (See any geodesy text, e.g. Snyder 1987, §3.)
using ColumnEntry = glm::dvec2;  ///< cosλ, sinλ
using RowEntry = glm::dvec4;     ///< N cosφ, cosφ, N(1−e²) sinφ, sinφ

/// Of a meridian or a parallel, in units of the lattice, see LatticePoint; beyond 180°E (90°N) that of the
/// last in the world.
ColumnEntry column_entry(std::int64_t x);
RowEntry row_entry(std::int64_t y, const Ellipsoid& ellipsoid);

/// The entries of all columns (rows) of samples of the tiles of a level in column x (row y) of the grid.
std::vector<ColumnEntry> column_table(int level, std::int32_t x, int tile_size);
std::vector<RowEntry> row_table(int level, std::int32_t y, int tile_size, const Ellipsoid& ellipsoid);

/// Geocentric metres.
inline glm::dvec3 position_of(const ColumnEntry& column, const RowEntry& row, double height_m) {
  const double from_axis = row.x + height_m * row.y;
  return {from_axis * column.x, from_axis * column.y, row.z + height_m * row.w};
}

}  // namespace cairn
