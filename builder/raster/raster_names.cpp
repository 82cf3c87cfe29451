#include "builder/raster/raster_names.h"

#include <algorithm>
#include <cctype>
#include <string>

namespace cairn {

bool has_raster_name(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto table = raster_names();
  return std::any_of(table.begin(), table.end(), [&](const RasterNames* names) {
    return std::find(names->extensions.begin(), names->extensions.end(), extension) !=
           names->extensions.end();
  });
}

}  // namespace cairn
