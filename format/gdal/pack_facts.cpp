#include "format/gdal/pack_facts.h"

#include <cmath>
#include <string>

namespace cairn {
namespace {

double number_at(const CPLJSONObject& object, const std::string& path) {
  return object.GetDouble(path, std::nan(""));
}

void set(GDALDataset& dataset, const std::string& key, double value) {
  if (!std::isnan(value)) dataset.GDALDataset::SetMetadataItem(key.c_str(), CPLSPrintf("%.10g", value));
}

void set_accuracy(GDALDataset& dataset, const CPLJSONObject& metadata) {
  set(dataset, "CAIRN_ERROR_BOUND_M", number_at(metadata, "error_bound_m"));
  for (const auto& [key, item] : {std::pair("posts", "CAIRN_POSTS"),
                                  {"max_m", "CAIRN_POST_ERROR_MAX_M"},
                                  {"rms_m", "CAIRN_POST_ERROR_RMS_M"},
                                  {"p50_m", "CAIRN_POST_ERROR_P50_M"},
                                  {"p95_m", "CAIRN_POST_ERROR_P95_M"},
                                  {"p99_m", "CAIRN_POST_ERROR_P99_M"},
                                  {"worst/lon", "CAIRN_POST_ERROR_MAX_LON"},
                                  {"worst/lat", "CAIRN_POST_ERROR_MAX_LAT"}})
    set(dataset, item, number_at(metadata, std::string("accuracy/") + key));
}

void set_levels(GDALDataset& dataset, const CPLJSONArray& levels, const char* measure, const char* item) {
  for (int i = 0; i < levels.Size(); ++i) {
    const std::string level = std::to_string(levels[i].GetInteger("level", 0));
    set(dataset, "CAIRN_LEVEL_" + level + "_" + item, number_at(levels[i], measure));
  }
}

}  // namespace

Result<CPLJSONObject> read_metadata(const PackReader& pack) {
  if (const Status status = pack.read_metadata(); !status) return status.error();
  CPLJSONDocument document;
  if (document.LoadMemory(std::string(pack.metadata_json()))) return document.GetRoot();
  return bad_data(pack.path().string() + ": metadata: expected a JSON object, found no JSON");
}

Result<GeoBounds> bounds_of(const PackReader& pack, const CPLJSONObject& metadata, Layer layer) {
  const std::string path = layer == Layer::imagery ? "imagery/bounds/" : "bounds/";
  const GeoBounds bounds{number_at(metadata, path + "west"), number_at(metadata, path + "south"),
                         number_at(metadata, path + "east"), number_at(metadata, path + "north")};
  if (bounds.west <= bounds.east && bounds.south <= bounds.north && bounds.south >= -90 &&
      bounds.north <= 90 && bounds.west >= -360 && bounds.east <= 720)
    return bounds;
  return bad_data(pack.path().string() + ": metadata: " + path.substr(0, path.size() - 1) +
                  ": expected west, south, east and north in degrees, found others");
}

void set_metadata_items(GDALDataset& dataset, const PackReader& pack, const CPLJSONObject& metadata,
                        Layer layer, int level) {
  const auto item = [&](const char* key, const std::string& value) {
    dataset.GDALDataset::SetMetadataItem(key, value.c_str());
  };
  item("AREA_OR_POINT", layer == Layer::heights ? "Point" : "Area");
  item("CAIRN_LEVEL", std::to_string(level));
  if (layer == Layer::heights) {
    item("CAIRN_VERTICAL_DATUM", std::string(pack.header().datum_name()));
    set(dataset, "CAIRN_QUANTUM_M", pack.header().quantum_m);
    set_accuracy(dataset, metadata);
    set_levels(dataset, metadata.GetArray("levels"), "max_error_m", "MAX_ERROR_M");
  } else {
    set_levels(dataset, metadata.GetArray("imagery/levels"), "psnr_db", "PSNR_DB");
  }
  const std::string json(pack.metadata_json());
  const char* domain[] = {json.c_str(), nullptr};
  dataset.GDALDataset::SetMetadata(const_cast<char**>(domain), "json:cairn");
}

}  // namespace cairn
