#include "runtime/gl/wall_batch.h"

#include <array>
#include <cstddef>
#include <cstdint>

namespace cairn::gl {
namespace {

// What terrain.vert takes of a vertex.
static_assert(sizeof(WallVertex) == 24 && sizeof(PerimeterVertex) == 8);
constexpr GLuint kPatch = 0, kPlace = 2, kWall = 3;

}  // namespace

WallBatch::WallBatch() {
  const GLuint vao = vertex_array_.name();
  glVertexArrayVertexBuffer(vao, 0, vertices_.name(), 0, sizeof(WallVertex));
  glVertexArrayElementBuffer(vao, indices_.name());
  for (const GLuint location : {kPatch, kPlace, kWall}) {
    glEnableVertexArrayAttrib(vao, location);
    glVertexArrayAttribBinding(vao, location, 0);
  }
  glVertexArrayAttribIFormat(vao, kPatch, 1, GL_UNSIGNED_INT, offsetof(WallVertex, patch));
  glVertexArrayAttribIFormat(vao, kWall, 3, GL_UNSIGNED_INT, offsetof(WallVertex, shown_as));
  glVertexArrayAttribFormat(vao, kPlace, 2, GL_FLOAT, GL_FALSE, offsetof(WallVertex, place));
}

std::size_t WallBatch::draw(const MeshPlan& plan, bool calls) {
  if (plan.wall_triangles.empty()) return 0;
  fill<WallVertex>(vertices_, plan.wall_vertices);
  fill<std::array<std::uint32_t, 3>>(indices_, plan.wall_triangles);
  glBindVertexArray(vertex_array_.name());
  if (calls) {
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(3 * plan.wall_triangles.size()), GL_UNSIGNED_INT,
                   nullptr);
  }
  return plan.wall_triangles.size();
}

}  // namespace cairn::gl
