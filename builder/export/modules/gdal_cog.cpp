// Cloud-optimized GeoTIFFs through GDAL's own driver, in the module that is loaded only when it is needed.
#include <filesystem>
#include <string>

#include <cpl_string.h>
#include <gdal.h>

#include "builder/raster/modules/gdal_session.h"
#include "cairn/status.h"

namespace cairn {
namespace {

Status copy_as_cog(const std::filesystem::path& from, const std::filesystem::path& to) {
  register_gdal(64 << 20);
  const Quiet quiet;
  const Dataset source(GDALOpen(from.c_str(), GA_ReadOnly));
  if (source == nullptr) return failed(from.string() + ": GDAL: " + Quiet::reason());
  GDALDriverH driver = GDALGetDriverByName("COG");
  if (driver == nullptr) return failed("GDAL: expected the driver COG, found none");
  char** options = nullptr;
  for (const char* option : {"BLOCKSIZE=512", "COMPRESS=DEFLATE", "PREDICTOR=YES", "BIGTIFF=IF_SAFER",
                             "OVERVIEW_RESAMPLING=BILINEAR", "RESAMPLING=BILINEAR"})
    options = CSLAddString(options, option);
  const Dataset copy(GDALCreateCopy(driver, to.c_str(), source.get(), FALSE, options, nullptr, nullptr));
  CSLDestroy(options);
  const bool good = copy != nullptr && CPLGetLastErrorType() < CE_Failure;
  return good ? Status() : Status(failed(to.string() + ": GDAL: " + Quiet::reason()));
}

}  // namespace
}  // namespace cairn

extern "C" __attribute__((visibility("default"))) void cairn_copy_as_cog(const std::filesystem::path& from,
                                                                         const std::filesystem::path& to,
                                                                         cairn::Status& out) {
  out = cairn::copy_as_cog(from, to);
}
