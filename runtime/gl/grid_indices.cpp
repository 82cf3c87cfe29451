#include "runtime/gl/grid_indices.h"

#include <vector>

namespace cairn::gl {

GLuint GridIndices::buffer(int cells_log2) {
  Buffer& buffer = buffers_[static_cast<std::size_t>(cells_log2)];
  if (buffer) return buffer.name();
  const std::uint32_t cells = 1u << cells_log2, row = cells + 1;
  std::vector<std::uint32_t> indices;
  indices.reserve(count(cells_log2));
  for (std::uint32_t j = 0; j < cells; ++j) {
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t sw = j * row + i, se = sw + 1, nw = sw + row, ne = nw + 1;
      indices.insert(indices.end(), {sw, se, ne, sw, ne, nw});
    }
  }
  buffer = make_buffer();
  glNamedBufferStorage(buffer.name(), static_cast<GLsizeiptr>(indices.size() * sizeof indices[0]),
                       indices.data(), 0);
  return buffer.name();
}

}  // namespace cairn::gl
