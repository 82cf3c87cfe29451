#include "runtime/viewer/numbered_file.h"

#include <cerrno>
#include <cstring>

namespace cairn::viewer {

Result<NumberedFile> create_numbered(const std::string& prefix, const std::string& suffix, int first) {
  for (int number = first;; ++number) {
    const std::string name = prefix + "-" + std::to_string(number) + "." + suffix;
    std::unique_ptr<std::FILE, CloseFile> file(std::fopen(name.c_str(), "wbx"));
    if (file) return NumberedFile{name, number, std::move(file)};
    if (errno != EEXIST) return failed(name + ": create: " + std::strerror(errno));
  }
}

}  // namespace cairn::viewer
