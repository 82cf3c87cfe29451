#include "builder/raster/packed_raster.h"

#include <algorithm>
#include <cctype>

#include "builder/raster/raster_names.h"

namespace cairn {
namespace {

bool has_extension(const std::filesystem::path& path, const std::string& extension) {
  const std::string own = path.extension().string();
  return std::equal(own.begin(), own.end(), extension.begin(), extension.end(),
                    [](unsigned char a, char b) { return std::tolower(a) == b; });
}

}  // namespace

bool is_zip_name(const std::filesystem::path& path) {
  return has_extension(path, ".zip");
}

bool is_gzip_name(const std::filesystem::path& path) {
  return has_extension(path, ".gz");
}

Result<std::vector<ZipEntry>> rasters_in_zip(const std::filesystem::path& path) {
  auto entries = list_zip(path);
  if (!entries) return entries;
  std::erase_if(*entries, [](const ZipEntry& entry) { return !has_raster_name(entry.name); });
  return entries;
}

bool is_raster_file(const std::filesystem::path& path) {
  if (is_gzip_name(path)) return has_raster_name(path.stem());
  if (!is_zip_name(path)) return has_raster_name(path);
  const auto rasters = rasters_in_zip(path);
  return !rasters || !rasters->empty();
}

}  // namespace cairn
