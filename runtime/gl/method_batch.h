#pragma once

#include <cstddef>
#include <span>

#include <glm/vec3.hpp>

#include "runtime/gl/gl_handle.h"
#include "runtime/gl/patch_records.h"
#include "runtime/lod/lod_method.h"

namespace cairn::gl {

/// The buffers of a mesh that a level-of-detail method has made, and the call that draws it.
class MethodBatch {
 public:
  MethodBatch();

  /// With the program and the textures bound that terrain.vert and .frag read, and its vertices' kind set. A
  /// record for each tile of the scene that the mesh is of. Returns the triangles. `calls` false: all but the
  /// draw call.
  std::size_t draw(const LodMesh& mesh, const LodScene& scene, std::span<const PatchRecord> records,
                   const glm::dvec3& eye, bool calls);

 private:
  Buffer patches_ = make_buffer();
  Buffer vertices_ = make_buffer();
  Buffer indices_ = make_buffer();
  VertexArray vertex_array_ = make_vertex_array();
};

}  // namespace cairn::gl
