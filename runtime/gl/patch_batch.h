#pragma once

#include <cstdint>

#include "cairn/surface_mesh.h"
#include "runtime/gl/gl_handle.h"

namespace cairn::gl {

/// A buffer that grows and keeps what it has.
class GrowingBuffer {
 public:
  void reserve(std::uint64_t bytes);
  GLuint name() const { return buffer_.name(); }
  std::uint64_t bytes() const { return bytes_; }

 private:
  Buffer buffer_;
  std::uint64_t bytes_ = 0;
};

/// The vertices and triangles of patches, kept from frame to frame, and the one call that draws a frame's.
class PatchBatch {
 public:
  PatchBatch();

  /// Takes what is new in a mesh.
  void take(const SurfaceMesh& mesh);
  /// Draws a mesh's patches, number i with the i-th record that is bound. `calls` false: all but the draw
  /// call.
  void draw(const SurfaceMesh& mesh, bool calls);
  std::uint64_t bytes() const { return vertices_.bytes() + indices_.bytes() + numbers_.bytes(); }

 private:
  void number(std::uint32_t count);

  GrowingBuffer vertices_;
  GrowingBuffer indices_;
  GrowingBuffer numbers_;  // of patches, an instance each
  std::uint32_t numbered_ = 0;
  Buffer commands_ = make_buffer();
  VertexArray vertex_array_ = make_vertex_array();
};

}  // namespace cairn::gl
