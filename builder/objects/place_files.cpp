#include "builder/objects/place_files.h"

#include <algorithm>
#include <cctype>
#include <string>

namespace cairn {
namespace {

std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

}  // namespace

Status read_places(const std::filesystem::path& file, const TakePlace& take) {
  const std::string extension = lower_extension(file);
  if (extension == ".geojson" || extension == ".json") return read_places_geojson(file, take);
  return read_places_csv(file, take);
}

}  // namespace cairn
