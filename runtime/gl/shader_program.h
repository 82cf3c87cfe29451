#pragma once

#include <span>
#include <string_view>

#include "cairn/status.h"
#include "runtime/gl/gl_handle.h"

namespace cairn::gl {

/// A shader's text, from runtime/gl/shaders/; the folder is the list.
struct ShaderSource {
  std::string_view name;  ///< the file's name, e.g. "terrain.vert"
  std::string_view text;
};
std::span<const ShaderSource> shader_sources();

/// Compiles and links NAME.vert and NAME.frag. failed names the file and gives the driver's first line.
Result<Program> link_program(std::string_view name);

}  // namespace cairn::gl
