#pragma once

#include <vector>

#include "cairn/status.h"
#include "runtime/gl/gl_handle.h"
#include "runtime/gl/picture.h"

namespace cairn::gl {

/// Where frames are drawn: sRGB colour and a 32-bit float depth, so that reversed depth keeps its precision.
/// With several samples a pixel, the colour that is read or shown is their mean, taken in linear light.
class FrameTarget {
 public:
  /// failed where the driver has no target of this size or no so many samples. REQUIRES: all >= 1.
  static Result<FrameTarget> create(int width, int height, int samples = 1);

  int width() const { return width_; }
  int height() const { return height_; }
  int samples() const { return samples_; }
  GLuint framebuffer() const { return framebuffer_.name(); }

  /// Returns a framebuffer with one sample a pixel that holds what has been drawn by now of its colour
  /// (GL_COLOR_BUFFER_BIT), its depth (GL_DEPTH_BUFFER_BIT) or both.
  GLuint resolve(GLbitfield parts) const;

  /// Waits for what has been drawn.
  Picture read() const;

  /// A value a pixel, of one of its samples, rows from top to bottom: kNear_m / distance along the view, 0
  /// where nothing is.
  std::vector<float> read_depth() const;

 private:
  FrameTarget() = default;
  int width_ = 0;
  int height_ = 0;
  int samples_ = 1;
  Texture colour_;
  Texture depth_;
  Framebuffer framebuffer_;
  Texture resolved_colour_;  // with several samples only
  Texture resolved_depth_;
  Framebuffer resolved_;
};

}  // namespace cairn::gl
