#pragma once

#include <vector>

#include "cairn/status.h"
#include "runtime/gl/gl_handle.h"
#include "runtime/gl/picture.h"

namespace cairn::gl {

/// Where frames are drawn: sRGB colour and a 32-bit float depth, so that reversed depth keeps its precision.
class FrameTarget {
 public:
  /// REQUIRES: width, height >= 1.
  static Result<FrameTarget> create(int width, int height);

  int width() const { return width_; }
  int height() const { return height_; }
  GLuint framebuffer() const { return framebuffer_.name(); }

  /// Waits for what has been drawn.
  Picture read() const;

  /// A value a pixel, rows from top to bottom: kNear_m / distance along the view, 0 where nothing is.
  std::vector<float> read_depth() const;

 private:
  FrameTarget() = default;
  int width_ = 0;
  int height_ = 0;
  Texture colour_;
  Texture depth_;
  Framebuffer framebuffer_;
};

}  // namespace cairn::gl
