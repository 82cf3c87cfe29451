#include "runtime/gl/shader_program.h"

#include <array>
#include <cassert>
#include <string>

namespace cairn::gl {
namespace {

const ShaderSource& source_of(const std::string& name) {
  for (const ShaderSource& source : shader_sources()) {
    if (source.name == name) return source;
  }
  assert(false);
  return shader_sources().front();
}

std::string first_line(std::string_view log) {
  return std::string(log.substr(0, log.find('\n')));
}

/// Returns a shader's text with each line `#include "NAME"` replaced by the text of that file.
std::string text_of(const std::string& name) {
  constexpr std::string_view kInclude = "#include \"";
  std::string text(source_of(name).text);
  for (std::size_t at = text.find(kInclude); at != std::string::npos; at = text.find(kInclude, at)) {
    const std::size_t begin = at + kInclude.size(), end = text.find('"', begin);
    text.replace(at, end + 1 - at, text_of(text.substr(begin, end - begin)));
  }
  return text;
}

Result<Shader> compile(const std::string& name, GLenum stage) {
  Shader shader(glCreateShader(stage));
  const std::string source = text_of(name);
  const char* text = source.data();
  const auto length = static_cast<GLint>(source.size());
  glShaderSource(shader.name(), 1, &text, &length);
  glCompileShader(shader.name());
  GLint compiled = 0;
  glGetShaderiv(shader.name(), GL_COMPILE_STATUS, &compiled);
  if (compiled) return shader;
  std::array<char, 1024> log{};
  glGetShaderInfoLog(shader.name(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  return failed(name + ": compile: expected a shader that this driver takes, found " +
                first_line(log.data()));
}

}  // namespace

Result<Program> link_program(std::string_view name) {
  Result<Shader> vertex = compile(std::string(name) + ".vert", GL_VERTEX_SHADER);
  if (!vertex) return vertex.error();
  Result<Shader> fragment = compile(std::string(name) + ".frag", GL_FRAGMENT_SHADER);
  if (!fragment) return fragment.error();
  Program program(glCreateProgram());
  glAttachShader(program.name(), vertex->name());
  glAttachShader(program.name(), fragment->name());
  glLinkProgram(program.name());
  GLint linked = 0;
  glGetProgramiv(program.name(), GL_LINK_STATUS, &linked);
  if (linked) return program;
  std::array<char, 1024> log{};
  glGetProgramInfoLog(program.name(), static_cast<GLsizei>(log.size()), nullptr, log.data());
  return failed(std::string(name) + ": link: expected a program that this driver takes, found " +
                first_line(log.data()));
}

}  // namespace cairn::gl
