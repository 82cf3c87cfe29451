// What no other reader claims or can open goes to GDAL, which lives in a module of its own (cairn-gdal.so)
// and is loaded by the first such file.
#include <array>
#include <filesystem>
#include <memory>
#include <string>

#include "builder/raster/raster_names.h"
#include "builder/raster/raster_source.h"
#include "builder/raster/reader_plugin.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

constexpr std::array kExtensions = {".vrt", ".asc", ".img", ".bil", ".flt",
                                    ".nc",  ".grd", ".dem", ".bt",  ".jp2"};

using OpenThroughGdal = void (*)(const fs::path& path, const OpenOptions& options,
                                 Result<std::unique_ptr<RasterSource>>& out);

bool claims(const fs::path&, std::span<const std::byte> first_bytes) {
  return !first_bytes.empty();
}

Result<std::unique_ptr<RasterSource>> open(const fs::path& path, const OpenOptions& options) {
  static const auto open_through_gdal =
      reinterpret_cast<OpenThroughGdal>(load_reader_plugin("cairn-gdal", "cairn_open_through_gdal"));
  if (open_through_gdal == nullptr)
    return bad_data(
        path.string() +
        ": expected a format that cairn reads itself, found another, and cairn-gdal.so cannot be loaded");
  Result<std::unique_ptr<RasterSource>> out(nullptr);
  open_through_gdal(path, options, out);
  return out;
}

}  // namespace

extern const RasterFormat gdal_format;
const RasterFormat gdal_format = {"gdal", 1000, claims, open};

extern const RasterNames gdal_names;
const RasterNames gdal_names = {kExtensions};

}  // namespace cairn
