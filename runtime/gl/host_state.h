#pragma once

#include <array>
#include <vector>

#include <epoxy/gl.h>

namespace cairn::gl {

/// What of a host's OpenGL state drawing depends on or changes: kept on construction, given back on
/// destruction. In between everything is as a fresh context has it, but for the framebuffer.
///
/// Not kept: a transform feedback, a conditional rendering or a time query in progress; a host ends these
/// before. Takes some 150 queries of the driver, a few microseconds each at most.
class HostState {
 public:
  HostState();
  ~HostState();
  HostState(const HostState&) = delete;
  HostState& operator=(const HostState&) = delete;

 private:
  struct Switch {
    GLenum name;
    bool was_on;
  };
  struct StoreValue {
    GLenum name;
    GLint value;
  };
  struct Unit {
    GLint texture;
    GLint sampler;
  };
  struct StorageBuffer {
    GLint buffer;
    GLint64 start;
    GLint64 size;
  };
  static constexpr GLuint kUnits = 6;
  static constexpr GLuint kStorages = 2;
  static constexpr GLuint kTargets = 8;  ///< that every context has at least

  std::vector<Switch> switches_;
  std::vector<StoreValue> stores_;
  std::array<Unit, kUnits> units_{};
  std::array<StorageBuffer, kStorages> storages_{};
  GLint storage_binding_ = 0;
  GLint draw_framebuffer_ = 0;
  std::array<GLfloat, 4> viewport_{};
  std::array<GLdouble, 2> depth_range_{};
  GLint clip_origin_ = 0;
  GLint clip_depth_ = 0;
  GLint depth_function_ = 0;
  GLboolean depth_mask_ = 0;
  std::array<std::array<GLboolean, 4>, kTargets> colour_masks_{};
  GLboolean blends_ = 0;
  GLboolean has_scissor_ = 0;
  std::array<GLint, 2> polygon_mode_{};
  GLint program_ = 0;
  GLint pipeline_ = 0;
  GLint vertex_array_ = 0;
  GLint indirect_buffer_ = 0;
  GLint unpack_buffer_ = 0;
};

}  // namespace cairn::gl
