// Cloud-optimized GeoTIFFs through GDAL's own driver, in the module that is loaded only when it is needed.
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>

#include <cpl_conv.h>
#include <cpl_error.h>
#include <cpl_string.h>
#include <gdal.h>

#include "cairn/status.h"

namespace cairn {
namespace {

struct CloseImage {
  void operator()(void* dataset) const { GDALClose(dataset); }
};
using Dataset = std::unique_ptr<void, CloseImage>;

std::string complaint() {
  const std::string text = CPLGetLastErrorMsg();
  return text.substr(0, text.find('\n'));
}

Status copy_as_cog(const std::filesystem::path& from, const std::filesystem::path& to) {
  static std::once_flag once;
  std::call_once(once, [] {
    GDALAllRegister();
    if (CPLGetConfigOption("GDAL_CACHEMAX", nullptr) == nullptr) GDALSetCacheMax64(64 << 20);
  });
  CPLPushErrorHandler(CPLQuietErrorHandler);
  CPLErrorReset();
  const auto end = [](Status status) {
    CPLPopErrorHandler();
    return status;
  };
  const Dataset source(GDALOpen(from.c_str(), GA_ReadOnly));
  if (source == nullptr) return end(failed(from.string() + ": GDAL: " + complaint()));
  GDALDriverH driver = GDALGetDriverByName("COG");
  if (driver == nullptr) return end(failed("GDAL: expected the driver COG, found none"));
  char** options = nullptr;
  for (const char* option : {"BLOCKSIZE=512", "COMPRESS=DEFLATE", "PREDICTOR=YES", "BIGTIFF=IF_SAFER",
                             "OVERVIEW_RESAMPLING=BILINEAR", "RESAMPLING=BILINEAR"})
    options = CSLAddString(options, option);
  const Dataset copy(GDALCreateCopy(driver, to.c_str(), source.get(), FALSE, options, nullptr, nullptr));
  CSLDestroy(options);
  const bool good = copy != nullptr && CPLGetLastErrorType() < CE_Failure;
  return end(good ? Status() : Status(failed(to.string() + ": GDAL: " + complaint())));
}

}  // namespace
}  // namespace cairn

extern "C" __attribute__((visibility("default"))) void cairn_copy_as_cog(const std::filesystem::path& from,
                                                                         const std::filesystem::path& to,
                                                                         cairn::Status& out) {
  out = cairn::copy_as_cog(from, to);
}
