#pragma once

#include <memory>
#include <mutex>
#include <string>

#include <cpl_conv.h>
#include <cpl_error.h>
#include <gdal.h>

namespace cairn {

struct CloseDataset {
  void operator()(void* dataset) const { GDALClose(dataset); }
};
/// A dataset of GDAL, closed at the end.
using Dataset = std::unique_ptr<void, CloseDataset>;

/// Silences GDAL on this thread for as long as it lives, and begins without an earlier error.
class Quiet {
 public:
  Quiet() {
    CPLPushErrorHandler(CPLQuietErrorHandler);
    CPLErrorReset();
  }
  ~Quiet() { CPLPopErrorHandler(); }
  Quiet(const Quiet&) = delete;
  Quiet& operator=(const Quiet&) = delete;

  /// Returns the first line of GDAL's last error on this thread; empty where it gave none.
  static std::string reason() {
    const std::string text = CPLGetLastErrorMsg();
    return text.substr(0, text.find('\n'));
  }
};

/// Registers GDAL's drivers, once in a process. The first call sets the cache of all datasets together to
/// this size, unless the user's environment sets it.
inline void register_gdal(GIntBig cache_bytes) {
  static std::once_flag once;
  std::call_once(once, [cache_bytes] {
    GDALAllRegister();
    if (CPLGetConfigOption("GDAL_CACHEMAX", nullptr) == nullptr) GDALSetCacheMax64(cache_bytes);
  });
}

}  // namespace cairn
