// Rasters beside a DEM that hold no heights: refused by name or by value, and nothing else is.

#include "builder/mosaic/companions.h"

#include <catch2/catch.hpp>

#include "tests/support/dem_files.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

enum class Content { hills, count, flat, error };

fs::path written(const TempDir& folder, const std::string& name, Content content, int columns = 100) {
  TiffRecipe recipe;
  recipe.columns = columns;
  recipe.type = content == Content::error ? SampleType::float32 : SampleType::int16;
  recipe.sample = [content](int, std::int64_t column, std::int64_t row) -> double {
    switch (content) {
      case Content::hills:
        return test_height(column, row);
      case Content::count:
        return static_cast<double>((column + row) % 7);
      case Content::flat:
        return 0;
      case Content::error:
        return 0.25 + 0.5 * static_cast<double>(column % 90);
    }
    return 0;
  };
  const fs::path path = folder.path() / name;
  write_tiff(path, recipe);
  return path;
}

std::string complaint(const std::vector<fs::path>& paths) {
  auto pool = RasterPool::open(paths, {}, RasterPool::Content::heights);
  REQUIRE(pool.ok());
  const Status status = refuse_companions(**pool);
  return status ? "" : status.error().message;
}

bool names(const std::string& complaint, const std::string& name) {
  return complaint.find("/" + name) != std::string::npos;
}

}  // namespace

TEST_CASE("companions of a DEM are refused by their name, whatever they hold, and listed") {
  const TempDir folder;
  const fs::path dem = written(folder, "Copernicus_DSM_10_N50_DEM.tif", Content::hills);
  const fs::path height_error = written(folder, "Copernicus_DSM_10_N50_HEM.tif", Content::error);
  const fs::path water = written(folder, "Copernicus_DSM_10_N50_WBM.tif", Content::count);
  const std::string found = complaint({dem, height_error, water});
  CHECK(names(found, "Copernicus_DSM_10_N50_HEM.tif"));
  CHECK(names(found, "Copernicus_DSM_10_N50_WBM.tif"));
  CHECK_FALSE(names(found, "Copernicus_DSM_10_N50_DEM.tif"));
  CHECK(found.find("found 2 rasters") != std::string::npos);
}

TEST_CASE("companions of any name are refused by their few small whole numbers") {
  const TempDir folder;
  const std::string found =
      complaint({written(folder, "z.tif", Content::hills), written(folder, "n.tif", Content::count)});
  CHECK(names(found, "n.tif"));
  CHECK_FALSE(names(found, "z.tif"));
}

TEST_CASE("DEMs are taken for what they are: alone, flat, or on another grid") {
  const TempDir folder;
  const fs::path hills = written(folder, "a_dem.tif", Content::hills);
  CHECK(complaint({hills, written(folder, "b_dem.tif", Content::hills)}).empty());
  CHECK(complaint({hills, written(folder, "c_count.tif", Content::count, 90)}).empty());
  CHECK(complaint({written(folder, "d_count.tif", Content::count)}).empty());
  CHECK(
      complaint({written(folder, "e.tif", Content::flat), written(folder, "f.tif", Content::flat)}).empty());
}

}  // namespace cairn::test
