#include "runtime/gl/frame_target.h"

#include <algorithm>
#include <cassert>
#include <string>
#include <utility>

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

struct Attachments {
  Texture colour;
  Texture depth;
  Framebuffer framebuffer;

  bool is_complete() const {
    return glCheckNamedFramebufferStatus(framebuffer.name(), GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE;
  }
};

Texture make_storage(GLenum format, int width, int height, int samples) {
  if (samples == 1) {
    Texture texture = make_texture(GL_TEXTURE_2D);
    glTextureStorage2D(texture.name(), 1, format, width, height);
    return texture;
  }
  Texture texture = make_texture(GL_TEXTURE_2D_MULTISAMPLE);
  glTextureStorage2DMultisample(texture.name(), samples, format, width, height, GL_TRUE);
  return texture;
}

Attachments attach(int width, int height, int samples) {
  Attachments made{make_storage(GL_SRGB8_ALPHA8, width, height, samples),
                   make_storage(GL_DEPTH_COMPONENT32F, width, height, samples), make_framebuffer()};
  glNamedFramebufferTexture(made.framebuffer.name(), GL_COLOR_ATTACHMENT0, made.colour.name(), 0);
  glNamedFramebufferTexture(made.framebuffer.name(), GL_DEPTH_ATTACHMENT, made.depth.name(), 0);
  return made;
}

/// The most samples a pixel that both colour and depth may have.
int most_samples() {
  GLint colour = 1, depth = 1;
  glGetInternalformativ(GL_TEXTURE_2D_MULTISAMPLE, GL_SRGB8_ALPHA8, GL_SAMPLES, 1, &colour);
  glGetInternalformativ(GL_TEXTURE_2D_MULTISAMPLE, GL_DEPTH_COMPONENT32F, GL_SAMPLES, 1, &depth);
  return std::max(std::min(colour, depth), 1);
}

}  // namespace

Result<FrameTarget> FrameTarget::create(int width, int height, int samples) {
  assert(width >= 1 && height >= 1 && samples >= 1);
  if (const int most = most_samples(); samples > most) {
    return failed("frame: expected at most " + std::to_string(most) +
                  " samples a pixel, which this driver has, found " + std::to_string(samples));
  }
  FrameTarget target;
  target.width_ = width;
  target.height_ = height;
  target.samples_ = samples;
  Attachments drawn = attach(width, height, samples);
  Attachments resolved = samples > 1 ? attach(width, height, 1) : Attachments{};
  if (!drawn.is_complete() || (samples > 1 && !resolved.is_complete())) {
    return failed("frame: " + std::to_string(width) + "x" + std::to_string(height) +
                  ": expected a size that this driver can draw, found one that it cannot");
  }
  target.colour_ = std::move(drawn.colour);
  target.depth_ = std::move(drawn.depth);
  target.framebuffer_ = std::move(drawn.framebuffer);
  target.resolved_colour_ = std::move(resolved.colour);
  target.resolved_depth_ = std::move(resolved.depth);
  target.resolved_ = std::move(resolved.framebuffer);
  return target;
}

GLuint FrameTarget::resolve(GLbitfield parts) const {
  if (samples_ == 1) return framebuffer_.name();
  // Without it the samples' mean would be that of their bytes, and darker than what they show.
  const GLboolean was_enabled = glIsEnabled(GL_FRAMEBUFFER_SRGB);
  glEnable(GL_FRAMEBUFFER_SRGB);
  glBlitNamedFramebuffer(framebuffer_.name(), resolved_.name(), 0, 0, width_, height_, 0, 0, width_, height_,
                         parts, GL_NEAREST);
  if (!was_enabled) glDisable(GL_FRAMEBUFFER_SRGB);
  return resolved_.name();
}

Picture FrameTarget::read() const {
  Picture picture{width_, height_, {}};
  picture.rgb.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_) * 3);
  read_pixels(resolve(GL_COLOR_BUFFER_BIT), width_, height_, GL_RGB, GL_UNSIGNED_BYTE, picture.rgb.data());
  turn_over(picture.rgb, height_);
  return picture;
}

std::vector<float> FrameTarget::read_depth() const {
  std::vector<float> depth(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  read_pixels(resolve(GL_DEPTH_BUFFER_BIT), width_, height_, GL_DEPTH_COMPONENT, GL_FLOAT, depth.data());
  turn_over(depth, height_);
  return depth;
}

}  // namespace cairn::gl
