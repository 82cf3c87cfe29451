#pragma once

#include <cstddef>

#include "runtime/gl/gl_handle.h"
#include "runtime/surface/mesh_plan.h"

namespace cairn::gl {

/// The buffers of a frame's walls and the call that draws them.
class WallBatch {
 public:
  WallBatch();

  /// With all bound that GridBatch::draw() left bound, and the vertices' kind set. Returns the triangles.
  /// `calls` false: all but the draw call.
  std::size_t draw(const MeshPlan& plan, bool calls);

 private:
  Buffer vertices_ = make_buffer();
  Buffer indices_ = make_buffer();
  VertexArray vertex_array_ = make_vertex_array();
};

}  // namespace cairn::gl
