#pragma once

#include <cstddef>

#include "cairn/surface_mesh.h"
#include "runtime/gl/gl_handle.h"

namespace cairn::gl {

/// What terrain.vert takes at location 4: the patch that a vertex glides with, and the one that it shows.
inline constexpr GLuint kPatchAttribute = 4;

/// Lets a vertex array take SurfaceVertex from a binding, at the locations 0…3 of terrain.vert.
inline void describe_vertices(GLuint vertex_array, GLuint binding) {
  for (GLuint location = 0; location < kPatchAttribute; ++location) {
    glEnableVertexArrayAttrib(vertex_array, location);
    glVertexArrayAttribBinding(vertex_array, location, binding);
  }
  glVertexArrayAttribFormat(vertex_array, 0, 3, GL_FLOAT, GL_FALSE, offsetof(SurfaceVertex, high));
  glVertexArrayAttribFormat(vertex_array, 1, 3, GL_FLOAT, GL_FALSE, offsetof(SurfaceVertex, low));
  glVertexArrayAttribFormat(vertex_array, 2, 2, GL_FLOAT, GL_FALSE, offsetof(SurfaceVertex, height_m));
  glVertexArrayAttribFormat(vertex_array, 3, 2, GL_UNSIGNED_SHORT, GL_FALSE, offsetof(SurfaceVertex, east));
}

}  // namespace cairn::gl
