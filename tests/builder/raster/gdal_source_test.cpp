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

TEST_CASE("A raster in another CRS comes from GDAL with its own posts, where PROJ puts them") {
  if (!has_gdal_reader()) return;
  const TempDir folder;
  const std::string at = folder.path().string() + "/";
  TiffRecipe recipe;
  recipe.pixel_scale = {100, 100, 0};
  recipe.tiepoint = {0, 0, 0, 4321000, 3210000, 0};
  recipe.keys = {{1024, 1}, {1025, 1}, {3072, 3035}};
  write_tiff(at + "x.tif", recipe);
  // One without a code has to be written as WKT.
  const std::string own = "+proj=laea +lat_0=52 +lon_0=10 +x_0=4321000 +y_0=3210000 +ellps=GRS80 +units=m";
  for (const std::string& crs : {std::string("EPSG:3035"), std::string("EPSG:3035+5730"), own}) {
    INFO(crs);
    if (!run_gdal("gdal_translate -of VRT -a_srs \"" + crs + "\" " + at + "x.tif " + at + "x.vrt")) return;
    const auto source = opened(at + "x.vrt");
    CHECK(source->info().columns == 100);
    CHECK(source->info().rows == 80);
    CHECK(all_heights(*source)[105] == static_cast<float>(test_height(5, 1)));
    const auto place = proj_transform("EPSG:3035", "EPSG:4326", {4321550, 3209850});
    if (!place) return;
    const LonLat found = source->info().georeference.place_of(5, 1);
    CHECK(found.lon == Approx((*place)[0]).epsilon(0).margin(1e-8));
    CHECK(found.lat == Approx((*place)[1]).epsilon(0).margin(1e-8));
  }
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
