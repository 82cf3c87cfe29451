#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// Returns how many indices a grid of vertices has in a form (Vaněk & Ježek 2004, table 1).
/// With m rows and n columns: 6(n-1)(m-1) in 1 part as a list, 5/2(n-1)(m-1) in (n-1)(m-1)/4 parts as fans,
/// 2n(m-1) in m-1 parts as strips, (2n+2)(m-1) in 1 part as a strip with degenerate triangles. REQUIRES:
/// m, n >= 2; for fans both odd.
IndexCount grid_index_count(IndexForm form, std::int64_t columns, std::int64_t rows);

/// Returns the indices of a grid, part after part; vertices are numbered along the rows from the south-west.
/// The strips are those of Vaněk & Ježek 2004, figures 1 and 2, with each pair of rows exchanged, so that
/// triangles face up where rows run to the north.
std::vector<std::uint32_t> grid_indices(IndexForm form, int columns, int rows);

/// Returns the triangles that a strip draws, with the strip's orientation and without degenerate ones.
std::vector<LodTriangle> triangles_of_strip(std::span<const std::uint32_t> strip);

}  // namespace cairn
