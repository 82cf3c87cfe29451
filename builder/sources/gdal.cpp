// What no other reader claims or can open goes to GDAL, which lives in a module of its own (cairn-gdal.so)
// and is loaded by the first such file: beside the program, or in ../lib/cairn of it.
#include <filesystem>
#include <memory>
#include <string>
#include <system_error>

#include <dlfcn.h>

#include "builder/raster_source.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

using OpenThroughGdal = void (*)(const fs::path& path, Result<std::unique_ptr<RasterSource>>& out);

OpenThroughGdal load_module() {
  std::error_code error;
  const fs::path folder = fs::read_symlink("/proc/self/exe", error).parent_path();
  for (const char* place : {"cairn-gdal.so", "../" CAIRN_LIBDIR "/cairn/cairn-gdal.so"}) {
    // Never closed: rasters that it opened may outlive any owner there could be.
    void* module = ::dlopen((folder / place).c_str(), RTLD_NOW | RTLD_LOCAL);
    if (module == nullptr) continue;
    return reinterpret_cast<OpenThroughGdal>(::dlsym(module, "cairn_open_through_gdal"));
  }
  return nullptr;
}

bool claims(const fs::path&, std::span<const std::byte> first_bytes) {
  return !first_bytes.empty();
}

Result<std::unique_ptr<RasterSource>> open(const fs::path& path, const OpenOptions&) {
  static const OpenThroughGdal open_through_gdal = load_module();
  if (open_through_gdal == nullptr)
    return bad_data(
        path.string() +
        ": expected a format that cairn reads itself, found another, and cairn-gdal.so cannot be loaded");
  Result<std::unique_ptr<RasterSource>> out(nullptr);
  open_through_gdal(path, out);
  return out;
}

}  // namespace

extern const RasterFormat gdal_format;
const RasterFormat gdal_format = {"gdal", 1000, claims, open};

}  // namespace cairn
