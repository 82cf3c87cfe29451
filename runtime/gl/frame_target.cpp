#include "runtime/gl/frame_target.h"

#include <algorithm>
#include <cassert>
#include <string>

namespace cairn::gl {
namespace {

void read_pixels(GLuint framebuffer, int width, int height, GLenum format, GLenum type, void* out) {
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width, height, format, type, out);
}

/// OpenGL's rows go up.
template <class T>
void turn_over(std::vector<T>& values, int rows) {
  const auto row_size = static_cast<std::ptrdiff_t>(values.size()) / rows;
  for (int low = 0, high = rows - 1; low < high; ++low, --high) {
    const auto at = [&](int row) { return values.begin() + row_size * row; };
    std::swap_ranges(at(low), at(low + 1), at(high));
  }
}

}  // namespace

Result<FrameTarget> FrameTarget::create(int width, int height) {
  assert(width >= 1 && height >= 1);
  FrameTarget target;
  target.width_ = width;
  target.height_ = height;
  target.colour_ = make_texture(GL_TEXTURE_2D);
  glTextureStorage2D(target.colour_.name(), 1, GL_SRGB8_ALPHA8, width, height);
  target.depth_ = make_texture(GL_TEXTURE_2D);
  glTextureStorage2D(target.depth_.name(), 1, GL_DEPTH_COMPONENT32F, width, height);
  target.framebuffer_ = make_framebuffer();
  const GLuint name = target.framebuffer_.name();
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, target.colour_.name(), 0);
  glNamedFramebufferTexture(name, GL_DEPTH_ATTACHMENT, target.depth_.name(), 0);
  if (glCheckNamedFramebufferStatus(name, GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    return failed("frame: " + std::to_string(width) + "x" + std::to_string(height) +
                  ": expected a size that this driver can draw, found one that it cannot");
  }
  return target;
}

Picture FrameTarget::read() const {
  Picture picture{width_, height_, {}};
  picture.rgb.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 3);
  read_pixels(framebuffer_.name(), width_, height_, GL_RGB, GL_UNSIGNED_BYTE, picture.rgb.data());
  turn_over(picture.rgb, height_);
  return picture;
}

std::vector<float> FrameTarget::read_depth() const {
  std::vector<float> depth(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  read_pixels(framebuffer_.name(), width_, height_, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data());
  turn_over(depth, height_);
  return depth;
}

}  // namespace cairn::gl
