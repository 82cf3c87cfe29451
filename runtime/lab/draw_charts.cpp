#include "runtime/lab/draw_charts.h"

#include <string>

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

namespace cairn {

Status draw_charts(const std::filesystem::path& folder) {
  std::error_code error;
  const auto self = std::filesystem::read_symlink("/proc/self/exe", error);
  const std::string program = (self.parent_path() / "cairn-lab-charts").string();
  std::string argument = folder.string(), name = program;
  char* arguments[] = {name.data(), argument.data(), nullptr};
  pid_t child = 0;
  if (error || ::posix_spawn(&child, program.c_str(), nullptr, nullptr, arguments, environ) != 0) {
    return failed(program + ": expected the program that draws the charts, found none");
  }
  int state = 0;
  if (::waitpid(child, &state, 0) != child || !WIFEXITED(state) || WEXITSTATUS(state) != 0) {
    return failed(program + ": expected charts of " + argument +
                  ", found an error (--no-charts leaves them out)");
  }
  return {};
}

}  // namespace cairn
