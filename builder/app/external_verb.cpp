#include "builder/app/external_verb.h"

#include <string>
#include <system_error>

#include <unistd.h>

namespace cairn {

std::optional<std::filesystem::path> find_external_verb(std::string_view verb) {
  if (verb.empty() || verb.front() == '-' || verb.find('/') != std::string_view::npos) return std::nullopt;
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  if (error) return std::nullopt;
  const auto program = self.parent_path() / ("cairn-" + std::string(verb));
  if (::access(program.c_str(), X_OK) != 0) return std::nullopt;
  return program;
}

void become(const std::filesystem::path& program, char** arguments) {
  ::execv(program.c_str(), arguments);
}

}  // namespace cairn
