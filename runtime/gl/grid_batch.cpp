#include "runtime/gl/grid_batch.h"

#include <array>
#include <cstdint>
#include <vector>

namespace cairn::gl {
GridBatch::GridBatch() {
  const GLuint vao = vertex_array_.name();
  glVertexArrayVertexBuffer(vao, 0, instances_.name(), 0, sizeof(std::uint32_t));
  glEnableVertexArrayAttrib(vao, 0);
  glVertexArrayAttribIFormat(vao, 0, 1, GL_UNSIGNED_INT, 0);
  glVertexArrayAttribBinding(vao, 0, 0);
  glVertexArrayBindingDivisor(vao, 0, 1);
}

std::size_t GridBatch::draw(std::span<const PatchRecord> records, std::span<const PerimeterVertex> perimeter,
                            const ColumnBuffer& columns, const RowBuffer& rows, bool calls) {
  std::array<std::vector<std::uint32_t>, kMaxCellsLog2 + 1> by_grid;
  for (std::uint32_t i = 0; i < records.size(); ++i) by_grid[records[i].cells_log2].push_back(i);
  std::vector<std::uint32_t> order;
  for (const auto& group : by_grid) order.insert(order.end(), group.begin(), group.end());
  fill(patches_, records);
  fill(perimeter_, perimeter);
  fill(instances_, std::span<const std::uint32_t>(order));

  glBindVertexArray(vertex_array_.name());
  const std::array<GLuint, 4> buffers = {patches_.name(), perimeter_.name(), columns.name(), rows.name()};
  glBindBuffersBase(GL_SHADER_STORAGE_BUFFER, 0, static_cast<GLsizei>(buffers.size()), buffers.data());
  std::size_t triangles = 0;
  std::uint32_t first = 0;
  for (int k = 0; k <= kMaxCellsLog2; ++k) {
    const auto instances = static_cast<std::uint32_t>(by_grid[static_cast<std::size_t>(k)].size());
    if (instances == 0) continue;
    glVertexArrayElementBuffer(vertex_array_.name(), indices_.buffer(k));
    if (calls) {
      glDrawElementsInstancedBaseInstance(GL_TRIANGLES, static_cast<GLsizei>(GridIndices::count(k)),
                                          GL_UNSIGNED_INT, nullptr, static_cast<GLsizei>(instances), first);
    }
    first += instances;
    triangles += std::size_t{instances} * GridIndices::count(k) / 3;
  }
  return triangles;
}

}  // namespace cairn::gl
