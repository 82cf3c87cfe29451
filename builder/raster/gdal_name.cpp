#include "builder/raster/gdal_name.h"

#include <cctype>
#include <string>
#include <string_view>
#include <system_error>

namespace cairn {
namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

// The shortest part of a path that is a file: the archive that the rest lies in.
std::optional<fs::path> archive_of(std::string_view path) {
  for (std::size_t end = path.find('/', 1);; end = path.find('/', end + 1)) {
    const fs::path part(path.substr(0, end));
    if (is_file(part)) return part;
    if (end == std::string_view::npos) return std::nullopt;
  }
}

// What stands behind /vsizip/, /vsitar/ and the like, one or several.
std::optional<fs::path> file_of_virtual_path(std::string_view path) {
  while (path.starts_with("/vsi")) {
    const std::size_t end = path.find('/', 1);
    if (end == std::string_view::npos) return std::nullopt;
    path.remove_prefix(end + 1);
  }
  return path.empty() ? std::nullopt : archive_of(path);
}

bool is_driver(std::string_view name) {
  for (const char c : name)
    if (std::isupper(static_cast<unsigned char>(c)) == 0 &&
        std::isdigit(static_cast<unsigned char>(c)) == 0 && c != '_')
      return false;
  return name.size() > 1;
}

// The longest part between colons that is a file.
std::optional<fs::path> file_of_subdataset(std::string_view rest) {
  if (rest.starts_with('"')) {
    const fs::path quoted(rest.substr(1, rest.find('"', 1) - 1));
    return is_file(quoted) ? std::optional(quoted) : std::nullopt;
  }
  for (std::size_t first = 0; first != std::string_view::npos;) {
    const std::string_view part = rest.substr(first);
    for (std::size_t end = part.size(); end != std::string_view::npos && end > 0;
         end = part.rfind(':', end - 1)) {
      const fs::path path(part.substr(0, end));
      if (is_file(path)) return path;
    }
    const std::size_t colon = rest.find(':', first);
    first = colon == std::string_view::npos ? colon : colon + 1;
  }
  return std::nullopt;
}

}  // namespace

std::optional<fs::path> file_of_gdal_name(const fs::path& name) {
  const std::string& text = name.native();
  if (is_file(name)) return std::nullopt;
  if (text.starts_with("/vsi")) return file_of_virtual_path(text);
  const std::size_t colon = text.find(':');
  if (colon == std::string::npos || !is_driver(std::string_view(text).substr(0, colon))) return std::nullopt;
  return file_of_subdataset(std::string_view(text).substr(colon + 1));
}

}  // namespace cairn
