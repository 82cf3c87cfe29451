#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "runtime/lod/mesh/lod_scene.h"

namespace cairn {

/// [0, Table 1], m rows and n columns of vertices: 6(n-1)(m-1) indices in 1 part as a list, 5/2(n-1)(m-1) in
/// (n-1)(m-1)/4 parts as fans, 2n(m-1) in m-1 as strips, (2n+2)(m-1) in 1 as a strip with degenerate
/// triangles. REQUIRES: m, n >= 2; for fans both odd.
IndexCount grid_index_count(IndexForm form, std::int64_t columns, std::int64_t rows);

/// The indices themselves, part after part; vertices are numbered along the rows from the south-west. The
/// strips are [0, Fig. 1 and 2], but for the order of each pair of rows: ours face up where rows run to the
/// north.
std::vector<std::uint32_t> grid_indices(IndexForm form, int columns, int rows);

/// The triangles that a strip draws, each facing as the strip's do; degenerate ones left out.
std::vector<LodTriangle> triangles_of_strip(std::span<const std::uint32_t> strip);

}  // namespace cairn
