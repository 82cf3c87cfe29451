#pragma once

#include <memory>

#include "cairn/status.h"

namespace cairn::gl {

/// An OpenGL 4.5 core context without a window or a display, current on the thread that made it: EGL on the
/// first device that has one, else on Mesa's surfaceless platform. Draw into a FrameTarget.
class HeadlessContext {
 public:
  static Result<HeadlessContext> create();
  HeadlessContext(HeadlessContext&&) noexcept;
  HeadlessContext& operator=(HeadlessContext&&) noexcept;
  ~HeadlessContext();

 private:
  struct State;
  explicit HeadlessContext(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace cairn::gl
