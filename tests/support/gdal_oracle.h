#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace cairn::test {

struct Post {
  std::int64_t column = 0;
  std::int64_t row = 0;
};

/// A band at the posts as GDAL's gdallocationinfo reads it, NaN where it has no value. Without that program,
/// WARNs that the comparison is skipped and returns nullopt.
std::optional<std::vector<double>> gdal_values(const std::filesystem::path& raster,
                                               const std::vector<Post>& posts, int band = 1);

/// Runs a GDAL command line with its output thrown away. Returns whether it succeeded; without GDAL, WARNs
/// and returns false.
bool run_gdal(const std::string& command);

/// Places through PROJ by gdaltransform, x y each; nullopt without it.
std::optional<std::vector<double>> proj_transform(const std::string& from, const std::string& to,
                                                  const std::vector<double>& xy);

/// The first post's place in the raster's CRS and the spacing by gdalinfo's "Origin" and "Pixel Size":
/// x0, y0, dx, dy of pixel centres.
std::optional<std::vector<double>> gdal_georeference(const std::filesystem::path& raster);

}  // namespace cairn::test
