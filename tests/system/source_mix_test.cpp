// Bakes of sources that go together in ways that once went wrong.

#include <catch2/catch.hpp>

#include "cairn/bake_estimate.h"
#include "cairn/build.h"
#include "tests/support/dem_files.h"
#include "tests/support/test_bake.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

// A pixel-is-point raster in lat/long of `columns` × `rows` posts from its north-western one.
TiffRecipe lattice(double west, double north, double posts_per_degree, int columns, int rows) {
  TiffRecipe recipe;
  recipe.columns = columns;
  recipe.rows = rows;
  recipe.keys[1025] = 2;
  recipe.pixel_scale = {1 / posts_per_degree, 1 / posts_per_degree, 0};
  recipe.tiepoint = {0, 0, 0, west, north, 0};
  return recipe;
}

}  // namespace

TEST_CASE("a region of a fine DEM over one of the whole Earth is baked") {
  const TempDir folder;
  const fs::path world = folder.path() / "world.tif", fine = folder.path() / "fine.tif";
  write_tiff(world, lattice(-180, 90, 4, 1440, 721));
  write_tiff(fine, lattice(121, 25, 600, 601, 601));
  BuildOptions options = bake_options({fine, world}, folder.path() / "o.cairn");
  for (const GeoBounds& region : {GeoBounds{117, 21, 125, 27}, GeoBounds{121.25, 24.25, 121.5, 24.5},
                                  GeoBounds{122, 24, 123, 25}, GeoBounds{-10, -10, 10, 10}}) {
    options.grid.region = region;
    INFO(region.west << " " << region.south);
    REQUIRE(dry_run(options).ok());
    bake(options);
  }
}

TEST_CASE("a bake without one valid post, or without one pixel, is an error and leaves no pack") {
  const TempDir folder;
  const fs::path path = folder.path() / "x.tif";
  TiffRecipe voids = lattice(10, 50, 100, 40, 40);
  voids.sample = [](int, std::int64_t, std::int64_t) { return -9999.0; };
  write_tiff(path, voids);
  const BuildOptions options = bake_options({path}, folder.path() / "o.cairn");
  const auto report = build(options, [](const Progress&) { return true; });
  REQUIRE_FALSE(report.ok());
  CHECK(report.error().message.find("expected a post with a value in the DEMs, found voids alone") !=
        std::string::npos);
  CHECK_FALSE(fs::exists(options.session.target));

  TiffRecipe image = lattice(10, 50, 100, 40, 40);
  image.type = SampleType::uint8;
  image.bands = 4;
  image.photometric = 2;
  image.extra_samples = {2};
  image.sample = [](int band, std::int64_t, std::int64_t) { return band == 3 ? 0.0 : 90.0; };
  write_tiff(path, image);
  BuildOptions images = bake_options({}, folder.path() / "o.cairn");
  images.imagery.inputs = {path};
  const auto empty = build(images, [](const Progress&) { return true; });
  REQUIRE_FALSE(empty.ok());
  CHECK(empty.error().message.find("expected a pixel that is not transparent") != std::string::npos);
}

}  // namespace cairn::test
