#include <fstream>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "builder/objects/place_feature.h"
#include "builder/objects/place_files.h"

namespace cairn {

Status read_places_geojson(const std::filesystem::path& file, const PlaceVisitor& visitor) {
  using FileJson = nlohmann::json;
  std::ifstream in(file, std::ios::binary);
  if (!in) return failed(file.string() + ": expected a file that can be read, found none");
  const FileJson json = FileJson::parse(in, nullptr, false);
  const FileJson type = json.is_object() && json.contains("type") ? json.at("type") : FileJson();
  const FileJson* features =
      type == "FeatureCollection" && json.contains("features") ? &json.at("features") : nullptr;
  const FileJson single = FileJson::array({type == "Feature" ? json : FileJson()});
  if (type == "Feature") features = &single;
  if (features == nullptr || !features->is_array())
    return bad_data(file.string() + ": expected a FeatureCollection of GeoJSON, found " +
                    (json.is_discarded() ? "no JSON" : "other JSON"));
  for (std::size_t i = 0; i < features->size(); ++i) {
    if (auto status = read_feature((*features)[i], visitor); !status)
      return Error{status.error().code,
                   fmt::format("{}: feature {}: {}", file.string(), i, status.error().message)};
  }
  return {};
}

}  // namespace cairn
