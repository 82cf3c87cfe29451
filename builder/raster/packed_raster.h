#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "builder/raster/io/zip_archive.h"
#include "cairn/status.h"

namespace cairn {

/// Returns whether the name is that of a zip archive (.zip), in whatever case.
bool is_zip_name(const std::filesystem::path& path);

/// Returns whether the name is that of a gzip file (.gz), in whatever case.
bool is_gzip_name(const std::filesystem::path& path);

/// The archive's files whose names are those of rasters, in the archive's order.
Result<std::vector<ZipEntry>> rasters_in_zip(const std::filesystem::path& path);

/// Returns whether a folder's file is to be read as a raster: by its name, for a gzip file by the name
/// without .gz, for a zip archive by the names in it. An archive that cannot be listed is one, so that its
/// error is reported.
bool is_raster_file(const std::filesystem::path& path);

}  // namespace cairn
