#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "cairn/status.h"

namespace cairn {

/// Takes a feature as a text of GeoJSON in degrees; `where` says its layer and number.
using TakeFeature = std::function<Status(const std::string& where, const std::string& geojson)>;

/// What the module cairn-gdal offers for files of vectors.
struct FeatureModule {
  /// Calls `take` for each feature of each layer that has geometries, in the order of the file.
  Status (*read)(const std::filesystem::path& file, const TakeFeature& take) = nullptr;
  /// Returns the files that it consists of, in order; none where it cannot be opened.
  std::vector<std::filesystem::path> (*files_of)(const std::filesystem::path& file) = nullptr;
};

/// Loads the module; null where there is none.
const FeatureModule* feature_module();

}  // namespace cairn
