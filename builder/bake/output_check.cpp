#include "builder/bake/output_check.h"

#include <string>
#include <system_error>

namespace cairn {

namespace fs = std::filesystem;

bool is_same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return fs::equivalent(a, b, error) && !error;
}

Status check_is_no_input(const fs::path& output, std::span<const fs::path> inputs) {
  for (const fs::path& input : inputs) {
    if (!is_same_file(output, input)) continue;
    return usage_error(output.string() + ": expected an output that is no input, found the input " +
                       input.string());
  }
  return {};
}

Status check_can_be_file(const fs::path& output) {
  std::error_code error;
  if (fs::is_directory(output, error))
    return usage_error(output.string() + ": expected a file's name, found a folder");
  const fs::path folder = output.has_parent_path() ? output.parent_path() : fs::path(".");
  if (!fs::is_directory(folder, error))
    return failed(output.string() + ": expected a folder " + folder.string() + ", found none");
  return {};
}

}  // namespace cairn
