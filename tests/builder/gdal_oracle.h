#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <vector>

namespace cairn::test {

struct Post {
  std::int64_t column = 0;
  std::int64_t row = 0;
};

/// Band 1 at the posts as GDAL's gdallocationinfo reads it, NaN where it has no value. Without that program,
/// WARNs that the comparison is skipped and returns nullopt.
std::optional<std::vector<double>> gdal_values(const std::filesystem::path& raster,
                                               const std::vector<Post>& posts);

/// The first post's place in the raster's CRS and the spacing by gdalinfo's "Origin" and "Pixel Size":
/// x0, y0, dx, dy of pixel centres.
std::optional<std::vector<double>> gdal_georeference(const std::filesystem::path& raster);

}  // namespace cairn::test
