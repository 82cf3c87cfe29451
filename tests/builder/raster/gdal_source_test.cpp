#include <cmath>

#include <catch2/catch.hpp>

#include "tests/support/dem_files.h"
#include "tests/support/gdal_oracle.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

bool has_gdal_reader() {
  for (const RasterFormat* format : raster_formats())
    if (std::string(format->name) == "gdal") return true;
  WARN("SKIPPED, nothing was checked: cairn was built without GDAL");
  return false;
}

}  // namespace

TEST_CASE("GDAL opens an ASCII grid, ENVI and a VRT with the posts where they were") {
  if (!has_gdal_reader()) return;
  const TempDir folder;
  const std::string at = folder.path().string() + "/";
  write_tiff(at + "x.tif", {});
  for (const auto& [format, name] : {std::pair{"AAIGrid", "x.asc"}, {"ENVI", "x.img"}, {"VRT", "x.vrt"}}) {
    INFO(format);
    if (!run_gdal(std::string("gdal_translate -of ") + format + " " + at + "x.tif " + at + name)) return;
    const auto source = opened(at + name);
    CHECK(source->info().format.starts_with("gdal "));
    CHECK(source->info().georeference.x0 == Approx(10.005));
    CHECK(source->info().georeference.y0 == Approx(49.995));
    CHECK(all_heights(*source)[105] == static_cast<float>(test_height(5, 1)));
  }
}

TEST_CASE("GDAL warps a raster in another CRS to WGS84, close to its posts") {
  if (!has_gdal_reader()) return;
  const TempDir folder;
  const std::string at = folder.path().string() + "/";
  TiffRecipe recipe;
  recipe.sample = [](int, std::int64_t c, std::int64_t r) {
    return static_cast<double>(1000 + 3 * c + 2 * r);
  };
  write_tiff(at + "x.tif", recipe);
  if (!run_gdal("gdalwarp -t_srs EPSG:3035 -r cubic -dstnodata -9999 " + at + "x.tif " + at + "laea.tif"))
    return;
  const auto source = opened(at + "laea.tif");
  const Georeference& g = source->info().georeference;
  CHECK(g.crs == Georeference::Crs::geographic);
  const auto heights = all_heights(*source);
  int compared = 0;
  for (int r = 10; r < 70; r += 5)
    for (int c = 10; c < 90; c += 5) {
      const auto post = g.post_at({10.005 + 0.01 * c, 49.995 - 0.01 * r});
      const auto i =
          static_cast<std::size_t>(std::lround(post.row) * source->info().columns + std::lround(post.column));
      if (std::isnan(heights[i])) continue;
      CHECK(std::abs(heights[i] - static_cast<float>(1000 + 3 * c + 2 * r)) < 6);
      ++compared;
    }
  CHECK(compared > 100);
  CHECK(std::isnan(heights[0]));
}

TEST_CASE("A cut or scrambled GeoTIFF is not accepted by way of GDAL") {
  const TempDir folder;
  const auto path = folder.path() / "x.tif";
  for (const int tile : {0, 32})
    for (const int compression : {1, 8}) {
      TiffRecipe recipe;
      recipe.tile = tile;
      recipe.compression = compression;
      write_tiff(path, recipe);
      const auto whole = read_bytes(path);
      for (const std::size_t cut : {std::size_t{2}, std::size_t{4}, std::size_t{8}, std::size_t{100},
                                    whole.size() / 4, whole.size() / 2, whole.size() - 300}) {
        INFO("tile " << tile << " compression " << compression << " cut to " << cut << " of "
                     << whole.size());
        write_bytes(path, {whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(cut)});
        CHECK_FALSE(complaint_of(path).empty());
      }
    }
}

}  // namespace cairn::test
