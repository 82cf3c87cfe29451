#include "builder/raster/io/temp_folder.h"

#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

#include <stdlib.h>

namespace cairn {

Result<TempFolder> TempFolder::make() {
  std::error_code error;
  std::string name = (std::filesystem::temp_directory_path(error) / "cairn-unpacked-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr)
    return failed(name + ": cannot make a temporary folder: " + std::strerror(errno));
  return TempFolder(std::filesystem::path(name));
}

TempFolder::~TempFolder() {
  std::error_code ignored;
  if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
}

TempFolder& TempFolder::operator=(TempFolder&& other) noexcept {
  std::swap(path_, other.path_);
  return *this;
}

}  // namespace cairn
