#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>

#include "cairn/surface_objects.h"
#include "runtime/gl/gl_handle.h"

namespace cairn::gl {

/// The models of a frame's objects on the GPU, each once, and the calls that draw them.
class ObjectBatch {
 public:
  ObjectBatch();

  /// Uploads the models that are new, and then drops those that are no longer in memory.
  void take(const SurfaceObjects& objects);
  /// Draws with the program in use, whose uniforms `views` and `extent` it sets. `calls` false: all but the
  /// draw calls.
  void draw(const SurfaceObjects& objects, GLuint program, bool calls);
  std::uint64_t bytes() const { return bytes_; }

 private:
  struct Model {
    std::weak_ptr<const ObjectModel> source;
    Buffer vertices;
    Buffer indices;
    Texture texture;
    Texture billboard;
    std::uint64_t bytes = 0;
  };
  static Model upload(const std::shared_ptr<const ObjectModel>& source);

  std::unordered_map<const ObjectModel*, Model> models_;
  std::uint64_t bytes_ = 0;
  Buffer instances_ = make_buffer();
  VertexArray triangles_ = make_vertex_array();
  VertexArray billboards_ = make_vertex_array();
};

}  // namespace cairn::gl
