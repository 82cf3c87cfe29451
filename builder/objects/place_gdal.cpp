#include <string>

#include <nlohmann/json.hpp>

#include "builder/objects/feature_module.h"
#include "builder/objects/place_feature.h"
#include "builder/objects/place_files.h"
#include "builder/raster/reader_plugin.h"

namespace cairn {

const FeatureModule* feature_module() {
  using Entry = const FeatureModule* (*)();
  static const auto entry = reinterpret_cast<Entry>(load_reader_plugin("cairn-gdal", "cairn_feature_module"));
  return entry == nullptr ? nullptr : entry();
}

Status read_places_gdal(const std::filesystem::path& file, const PlaceVisitor& visitor) {
  const FeatureModule* module = feature_module();
  if (module == nullptr)
    return bad_data(file.string() +
                    ": expected CSV or GeoJSON, found another name, and cairn-gdal.so cannot be loaded");
  return module->read(file, [&](const std::string& where, const std::string& geojson) -> Status {
    const nlohmann::json feature = nlohmann::json::parse(geojson, nullptr, false);
    const auto status = read_feature(feature, visitor);
    if (status) return status;
    return Error{status.error().code, file.string() + ": " + where + ": " + status.error().message};
  });
}

}  // namespace cairn
