#pragma once

#include <cstdint>
#include <span>

#include "cairn/surface_mesh.h"
#include "runtime/gl/gl_handle.h"

namespace cairn::gl {

/// Triangles that are made anew for each frame, and the call that draws them.
class LooseBatch {
 public:
  LooseBatch();

  /// `calls` false: all but the draw call.
  void draw(std::span<const SurfaceWallVertex> vertices, std::span<const std::uint32_t> indices, bool calls);

 private:
  Buffer vertices_ = make_buffer();
  Buffer indices_ = make_buffer();
  VertexArray vertex_array_ = make_vertex_array();
};

}  // namespace cairn::gl
