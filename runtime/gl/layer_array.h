#pragma once

#include <cstdint>

#include "runtime/gl/gl_handle.h"

namespace cairn::gl {

/// An array texture of equal square layers that can grow.
class LayerArray {
 public:
  LayerArray() = default;
  LayerArray(GLenum format, int size, int mips) : format_(format), size_(size), mips_(mips) {}

  /// Makes room for so many layers; those that it has keep their texels. `configure` sets the new texture's
  /// filters.
  template <class Configure>
  void grow(std::uint32_t layers, Configure configure) {
    Texture larger = make_texture(GL_TEXTURE_2D_ARRAY);
    glTextureStorage3D(larger.name(), mips_, format_, size_, size_, static_cast<GLsizei>(layers));
    configure(larger.name());
    for (int mip = 0; layers_ > 0 && mip < mips_; ++mip) {
      glCopyImageSubData(texture_.name(), GL_TEXTURE_2D_ARRAY, mip, 0, 0, 0, larger.name(),
                         GL_TEXTURE_2D_ARRAY, mip, 0, 0, 0, size_ >> mip, size_ >> mip,
                         static_cast<GLsizei>(layers_));
    }
    texture_ = std::move(larger);
    layers_ = layers;
  }

  GLuint name() const { return texture_.name(); }
  GLenum format() const { return format_; }
  int size() const { return size_; }
  int mips() const { return mips_; }
  std::uint32_t layers() const { return layers_; }

 private:
  GLenum format_ = 0;
  int size_ = 0;
  int mips_ = 1;
  std::uint32_t layers_ = 0;
  Texture texture_;
};

}  // namespace cairn::gl
