#include "builder/objects/place_files.h"

#include <algorithm>
#include <cctype>
#include <string>

#include "builder/objects/feature_module.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

enum class PlaceFormat { csv, geojson, gdal };

PlaceFormat format_of(const fs::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".csv" || extension == ".txt") return PlaceFormat::csv;
  return extension == ".geojson" || extension == ".json" ? PlaceFormat::geojson : PlaceFormat::gdal;
}

}  // namespace

Status read_places(const fs::path& file, const PlaceVisitor& visitor) {
  switch (format_of(file)) {
    case PlaceFormat::csv:
      return read_places_csv(file, visitor);
    case PlaceFormat::geojson:
      return read_places_geojson(file, visitor);
    case PlaceFormat::gdal:
      break;
  }
  return read_places_gdal(file, visitor);
}

std::vector<fs::path> files_of_places(const fs::path& file) {
  const FeatureModule* module = format_of(file) == PlaceFormat::gdal ? feature_module() : nullptr;
  std::vector<fs::path> files;
  if (module != nullptr) files = module->files_of(file);
  if (files.empty()) files.push_back(file);
  return files;
}

}  // namespace cairn
