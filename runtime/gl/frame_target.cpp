#include "runtime/gl/frame_target.h"

#include <algorithm>
#include <cassert>
#include <string>

namespace cairn::gl {

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
  const std::size_t row_bytes = static_cast<std::size_t>(width_) * 3;
  picture.rgb.resize(row_bytes * static_cast<std::size_t>(height_));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.name());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, width_, height_, GL_RGB, GL_UNSIGNED_BYTE, picture.rgb.data());
  // OpenGL's rows go up.
  for (int low = 0, high = height_ - 1; low < high; ++low, --high) {
    const auto at = [&](int row) {
      return picture.rgb.begin() + static_cast<std::ptrdiff_t>(row_bytes) * row;
    };
    std::swap_ranges(at(low), at(low + 1), at(high));
  }
  return picture;
}

}  // namespace cairn::gl
