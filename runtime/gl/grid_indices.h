#pragma once

#include <array>
#include <cstdint>

#include "runtime/gl/gl_handle.h"
#include "runtime/surface/surface_tile.h"

namespace cairn::gl {

/// The triangles of grids of 2^k × 2^k cells, k = 0…9, made when first asked for. Vertex (i, j) has the
/// number j·(2^k+1) + i; each cell's diagonal runs from south-west to north-east; counter-clockwise seen from
/// above.
class GridIndices {
 public:
  GLuint buffer(int cells_log2);
  static std::uint32_t count(int cells_log2) { return 6u << (2 * cells_log2); }

 private:
  std::array<Buffer, kMaxCellsLog2 + 1> buffers_;
};

}  // namespace cairn::gl
