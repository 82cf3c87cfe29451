#include "runtime/gl/loose_batch.h"

#include <cstddef>

#include "runtime/gl/vertex_format.h"

namespace cairn::gl {

LooseBatch::LooseBatch() {
  const GLuint vao = vertex_array_.name();
  static_assert(offsetof(SurfaceWallVertex, vertex) == 0);
  describe_vertices(vao, 0);
  glEnableVertexArrayAttrib(vao, kPatchAttribute);
  glVertexArrayAttribIFormat(vao, kPatchAttribute, 2, GL_UNSIGNED_INT, offsetof(SurfaceWallVertex, patch));
  glVertexArrayAttribBinding(vao, kPatchAttribute, 0);
  glVertexArrayVertexBuffer(vao, 0, vertices_.name(), 0, sizeof(SurfaceWallVertex));
  glVertexArrayElementBuffer(vao, indices_.name());
}

void LooseBatch::draw(std::span<const SurfaceWallVertex> vertices, std::span<const std::uint32_t> indices,
                      bool calls) {
  if (indices.empty()) return;
  fill(vertices_, vertices);
  fill(indices_, indices);
  if (!calls) return;
  glBindVertexArray(vertex_array_.name());
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(indices.size()), GL_UNSIGNED_INT, nullptr);
}

}  // namespace cairn::gl
