#pragma once

#include <string_view>

#include <epoxy/gl.h>

namespace cairn::gl {

/// Whether the current context is that of Mesa's software driver.
inline bool draws_in_software() {
  const auto* name = reinterpret_cast<const char*>(glGetString(GL_RENDERER));
  return name && std::string_view(name).find("llvmpipe") != std::string_view::npos;
}

}  // namespace cairn::gl
