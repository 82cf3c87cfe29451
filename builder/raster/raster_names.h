#pragma once

#include <filesystem>
#include <span>

namespace cairn {

/// The endings of a format's file names, in lower case with their dot, by which a folder's files are known to
/// be rasters. Each file of builder/raster/formats/ defines one, NAME_names, which may be empty.
struct RasterNames {
  std::span<const char* const> extensions;
};
std::span<const RasterNames* const> raster_names();

/// Returns whether the name ends as those of some format do, in whatever case.
bool has_raster_name(const std::filesystem::path& path);

}  // namespace cairn
