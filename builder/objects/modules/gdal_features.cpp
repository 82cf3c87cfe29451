// Points and polygons of what GDAL's vector drivers read, as GeoJSON in degrees.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>
#include <type_traits>
#include <vector>

#include <cpl_string.h>
#include <gdal.h>
#include <nlohmann/json.hpp>
#include <ogr_api.h>
#include <ogr_srs_api.h>

#include "builder/objects/feature_module.h"
#include "builder/raster/modules/gdal_session.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr GIntBig kVectorCacheBytes = 16 << 20;  // as that of rasters
constexpr double kLeastEarth_m = 6.3e6, kMostEarth_m = 6.4e6;

/// Ends a handle of GDAL's C interface, all of which may be pointers to void.
template <auto kEnd>
struct EndHandle {
  template <class Handle>
  void operator()(Handle handle) const {
    kEnd(handle);
  }
};
using Crs =
    std::unique_ptr<std::remove_pointer_t<OGRSpatialReferenceH>, EndHandle<OSRDestroySpatialReference>>;
using ToDegrees = std::unique_ptr<std::remove_pointer_t<OGRCoordinateTransformationH>,
                                  EndHandle<OCTDestroyCoordinateTransformation>>;
using Feature = std::unique_ptr<std::remove_pointer_t<OGRFeatureH>, EndHandle<OGR_F_Destroy>>;
using Geometry = std::unique_ptr<std::remove_pointer_t<OGRGeometryH>, EndHandle<OGR_G_DestroyGeometry>>;

Dataset open_vectors(const fs::path& file) {
  register_gdal(kVectorCacheBytes);
  return Dataset(GDALOpenEx(file.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, nullptr,
                            nullptr, nullptr));
}

/// From the layer's CRS to degrees: WGS84's on the Earth, its own on another body. Null where it has none.
Result<ToDegrees> transform_of(OGRLayerH layer) {
  OGRSpatialReferenceH crs = OGR_L_GetSpatialRef(layer);
  if (crs == nullptr) return ToDegrees();
  const Crs from(OSRClone(crs));
  OGRErr error = OGRERR_NONE;
  const double radius = OSRGetSemiMajor(from.get(), &error);
  const bool is_earth = error != OGRERR_NONE || (radius > kLeastEarth_m && radius < kMostEarth_m);
  const Crs to(is_earth ? OSRNewSpatialReference(nullptr) : OSRCloneGeogCS(from.get()));
  if (to == nullptr || (is_earth && OSRImportFromEPSG(to.get(), 4326) != OGRERR_NONE))
    return failed("CRS: GDAL: " + Quiet::reason());
  for (const auto& each : {from.get(), to.get()}) OSRSetAxisMappingStrategy(each, OAMS_TRADITIONAL_GIS_ORDER);
  ToDegrees transform(OCTNewCoordinateTransformation(from.get(), to.get()));
  if (transform == nullptr)
    return bad_data("CRS: expected one that becomes degrees, found: " + Quiet::reason());
  return transform;
}

Json properties_of(OGRFeatureH feature) {
  Json properties = Json::object();
  for (int i = 0; i < OGR_F_GetFieldCount(feature); ++i) {
    if (OGR_F_IsFieldSetAndNotNull(feature, i) == 0) continue;
    OGRFieldDefnH field = OGR_F_GetFieldDefnRef(feature, i);
    const OGRFieldType type = OGR_Fld_GetType(field);
    Json& value = properties[OGR_Fld_GetNameRef(field)];
    if (type == OFTInteger || type == OFTInteger64)
      value = OGR_F_GetFieldAsInteger64(feature, i);
    else if (type == OFTReal)
      value = OGR_F_GetFieldAsDouble(feature, i);
    else
      value = OGR_F_GetFieldAsString(feature, i);
  }
  return properties;
}

Result<std::string> geojson_of(OGRFeatureH feature, const ToDegrees& transform) {
  OGRGeometryH own = OGR_F_GetGeometryRef(feature);
  if (own == nullptr) return bad_data("geometry: expected one, found none");
  const Geometry geometry(OGR_G_GetLinearGeometry(own, 0, nullptr));
  if (geometry == nullptr ||
      (transform != nullptr && OGR_G_Transform(geometry.get(), transform.get()) != OGRERR_NONE))
    return bad_data("geometry: expected one that becomes degrees, found: " + Quiet::reason());
  char** options = CSLAddString(nullptr, "COORDINATE_PRECISION=12");
  char* text = OGR_G_ExportToJsonEx(geometry.get(), options);
  CSLDestroy(options);
  const std::string shape = text != nullptr ? text : "null";
  CPLFree(text);
  return R"({"type":"Feature","geometry":)" + shape + R"(,"properties":)" +
         properties_of(feature).dump(-1, ' ', false, Json::error_handler_t::replace) + "}";
}

Status read_layer(const fs::path& file, OGRLayerH layer, const TakeFeature& take) {
  const std::string name = file.string() + ": layer " + OGR_L_GetName(layer) + ": ";
  const auto transform = transform_of(layer);
  if (!transform) return Error{transform.error().code, name + transform.error().message};
  OGR_L_ResetReading(layer);
  CPLErrorReset();
  while (const Feature feature{OGR_L_GetNextFeature(layer)}) {
    const std::string where = std::string("layer ") + OGR_L_GetName(layer) + ": feature " +
                              std::to_string(OGR_F_GetFID(feature.get()));
    const auto text = geojson_of(feature.get(), *transform);
    if (!text) return Error{text.error().code, file.string() + ": " + where + ": " + text.error().message};
    if (auto status = take(where, *text); !status) return status;
  }
  if (CPLGetLastErrorType() < CE_Failure) return {};
  return bad_data(name + "expected features that can be read, found: " + Quiet::reason());
}

Status read_features(const fs::path& file, const TakeFeature& take) {
  const Quiet quiet;
  const Dataset dataset = open_vectors(file);
  if (dataset == nullptr) {
    const std::string reason = Quiet::reason();
    return bad_data(file.string() + ": expected CSV, GeoJSON or a format of GDAL's vector drivers, found: " +
                    (reason.empty() ? "another" : reason));
  }
  for (int i = 0; i < GDALDatasetGetLayerCount(dataset.get()); ++i) {
    OGRLayerH layer = GDALDatasetGetLayer(dataset.get(), i);
    if (OGR_L_GetGeomType(layer) == wkbNone) continue;  // a table
    if (auto status = read_layer(file, layer, take); !status) return status;
  }
  return {};
}

std::vector<fs::path> files_of_vectors(const fs::path& file) {
  const Quiet quiet;
  const Dataset dataset = open_vectors(file);
  if (dataset == nullptr) return {};
  char** names = GDALGetFileList(dataset.get());
  std::vector<fs::path> files;
  std::error_code error;
  for (char** name = names; name != nullptr && *name != nullptr; ++name)
    if (fs::is_regular_file(*name, error)) files.emplace_back(*name);
  CSLDestroy(names);
  std::sort(files.begin(), files.end());
  return files;
}

constexpr FeatureModule kModule{read_features, files_of_vectors};

}  // namespace
}  // namespace cairn

extern "C" __attribute__((visibility("default"))) const cairn::FeatureModule* cairn_feature_module() {
  return &cairn::kModule;
}
