#include "runtime/gl/patch_batch.h"

#include <algorithm>
#include <array>
#include <vector>

#include "runtime/gl/vertex_format.h"

namespace cairn::gl {
namespace {

/// As glMultiDrawElementsIndirect takes it.
struct Command {
  std::uint32_t count;
  std::uint32_t instances;
  std::uint32_t first_index;
  std::int32_t first_vertex;
  std::uint32_t first_instance;
};
static_assert(sizeof(Command) == 20);

// A buffer that grows is copied, and its new memory is touched for the first time: both in one frame.
constexpr std::uint64_t kFirstVertices = 1 << 20, kFirstIndices = 1 << 22;

}  // namespace

void GrowingBuffer::reserve(std::uint64_t bytes) {
  if (bytes <= bytes_) return;
  const std::uint64_t larger_bytes = 2 * bytes;
  Buffer larger = make_buffer();
  glNamedBufferStorage(larger.name(), static_cast<GLsizeiptr>(larger_bytes), nullptr, GL_DYNAMIC_STORAGE_BIT);
  if (bytes_ > 0) {
    glCopyNamedBufferSubData(buffer_.name(), larger.name(), 0, 0, static_cast<GLsizeiptr>(bytes_));
  }
  buffer_ = std::move(larger);
  bytes_ = larger_bytes;
}

PatchBatch::PatchBatch() {
  vertices_.reserve(kFirstVertices / 2 * sizeof(SurfaceVertex));
  indices_.reserve(kFirstIndices / 2 * sizeof(std::uint16_t));
  const GLuint vao = vertex_array_.name();
  describe_vertices(vao, 0);
  glEnableVertexArrayAttrib(vao, kPatchAttribute);
  glVertexArrayAttribIFormat(vao, kPatchAttribute, 2, GL_UNSIGNED_INT, 0);
  glVertexArrayAttribBinding(vao, kPatchAttribute, 1);
  glVertexArrayBindingDivisor(vao, 1, 1);
}

void PatchBatch::take(const SurfaceMesh& mesh) {
  vertices_.reserve(std::uint64_t{mesh.vertex_end} * sizeof(SurfaceVertex));
  indices_.reserve(std::uint64_t{mesh.index_end} * sizeof(std::uint16_t));
  for (const SurfaceUpload& upload : mesh.uploads) {
    glNamedBufferSubData(
        vertices_.name(), static_cast<GLintptr>(std::uint64_t{upload.first_vertex} * sizeof(SurfaceVertex)),
        static_cast<GLsizeiptr>(upload.vertices.size() * sizeof(SurfaceVertex)), upload.vertices.data());
    glNamedBufferSubData(
        indices_.name(), static_cast<GLintptr>(std::uint64_t{upload.first_index} * sizeof(std::uint16_t)),
        static_cast<GLsizeiptr>(upload.indices.size() * sizeof(std::uint16_t)), upload.indices.data());
  }
}

void PatchBatch::number(std::uint32_t count) {
  if (count <= numbered_) return;
  numbers_.reserve(std::uint64_t{count} * sizeof(std::array<std::uint32_t, 2>));
  numbered_ = static_cast<std::uint32_t>(numbers_.bytes() / sizeof(std::array<std::uint32_t, 2>));
  std::vector<std::array<std::uint32_t, 2>> numbers(numbered_);
  for (std::uint32_t i = 0; i < numbered_; ++i) numbers[i] = {i, i};
  glNamedBufferSubData(numbers_.name(), 0, static_cast<GLsizeiptr>(numbers.size() * sizeof numbers[0]),
                       numbers.data());
}

void PatchBatch::draw(const SurfaceMesh& mesh, bool calls) {
  if (mesh.draws.empty()) return;
  number(static_cast<std::uint32_t>(mesh.draws.size()));
  std::vector<Command> commands;
  commands.reserve(mesh.draws.size());
  for (std::uint32_t i = 0; i < mesh.draws.size(); ++i) {
    const SurfaceDraw& draw = mesh.draws[i];
    if (draw.index_count == 0) continue;
    commands.push_back(
        {draw.index_count, 1, draw.first_index, static_cast<std::int32_t>(draw.first_vertex), i});
  }
  if (commands.empty()) return;
  fill<Command>(commands_, commands);
  if (!calls) return;
  const GLuint vao = vertex_array_.name();
  glVertexArrayVertexBuffer(vao, 0, vertices_.name(), 0, sizeof(SurfaceVertex));
  glVertexArrayVertexBuffer(vao, 1, numbers_.name(), 0, sizeof(std::array<std::uint32_t, 2>));
  glVertexArrayElementBuffer(vao, indices_.name());
  glBindVertexArray(vao);
  glBindBuffer(GL_DRAW_INDIRECT_BUFFER, commands_.name());
  glMultiDrawElementsIndirect(GL_TRIANGLES, GL_UNSIGNED_SHORT, nullptr, static_cast<GLsizei>(commands.size()),
                              0);
}

}  // namespace cairn::gl
