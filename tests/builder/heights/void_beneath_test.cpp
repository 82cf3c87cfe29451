// A fine raster with a void over a coarse one without: the coarse one shows in the void, and no cliff around
// it.

#include <cmath>

#include <GeographicLib/UTMUPS.hpp>
#include <catch2/catch.hpp>

#include "cairn/build.h"
#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "format/pack_verify.h"
#include "tests/support/dem_files.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

constexpr double kOffset = 20;  // metres that the coarse raster lies above the fine one
constexpr double kHill = 400;

double plane(double lon, double lat) {
  return 1000 + 300 * (lon - 20) + 200 * (lat - 10);
}

double hill(double lon, double lat) {
  const double distance = std::hypot(lon - 20.5, lat - 10.5);
  return distance < 0.1 ? kHill * std::pow(std::cos(distance / 0.1 * 1.5707963), 2) : 0;
}

bool is_void(double lon, double lat) {
  return std::abs(lon - 20.5) < 0.2 && std::abs(lat - 10.5) < 0.2;
}

int fine_height(std::int64_t column, std::int64_t row) {
  const double lon = 20 + static_cast<double>(column) / 1200;
  const double lat = 11 - static_cast<double>(row) / 1200;
  return is_void(lon, lat) ? -32768 : static_cast<int>(std::lround(plane(lon, lat)));
}

// 120 posts a degree, pixel-is-point, a degree more on each side.
test::TiffRecipe coarse_raster() {
  test::TiffRecipe recipe;
  recipe.columns = recipe.rows = 361;
  recipe.pixel_scale = {1.0 / 120, 1.0 / 120, 0};
  recipe.tiepoint = {0, 0, 0, 19, 12, 0};
  recipe.keys = {{1024, 2}, {1025, 2}, {2048, 4326}};
  recipe.sample = [](int, std::int64_t column, std::int64_t row) {
    const double lon = 19 + static_cast<double>(column) / 120;
    const double lat = 12 - static_cast<double>(row) / 120;
    return std::round(plane(lon, lat) + kOffset + hill(lon, lat));
  };
  return recipe;
}

double height_at(PackSampler& sampler, double lon, double lat) {
  const auto height = sampler.height_at({lon, lat});
  REQUIRE(height.ok());
  REQUIRE(height->has_value());
  return (*height)->metres;
}

}  // namespace

TEST_CASE("a coarser raster shows in the voids of a finer one, without a cliff around them", "[slow]") {
  const test::TempDir dir;
  test::write_bytes(dir.path() / "N10E020.hgt", test::hgt_bytes(1201, fine_height));
  test::write_tiff(dir.path() / "coarse.tif", coarse_raster());
  BuildOptions options;
  options.mosaic.inputs = {dir.path() / "coarse.tif", dir.path() / "N10E020.hgt"};
  options.session.target = dir.path() / "a.cairn";
  options.session.force = true;
  options.session.threads = 2;
  for (const VoidMode voids : {VoidMode::fill, VoidMode::keep}) {
    options.heights.voids = voids;
    const auto report = build(options, [](const Progress&) { return true; });
    INFO((report.ok() ? "" : report.error().message));
    REQUIRE(report.ok());
    CHECK(verify_pack(options.session.target)->ok());
    auto pack = PackReader::open(options.session.target);
    REQUIRE(pack.ok());
    PackSampler sampler(*pack, 64);

    // Well inside the void the coarse raster's posts are the surface; a second of it is a fine post's third.
    for (double lon = 20.34; lon < 20.66; lon += 1.0 / 120) {
      for (double lat = 10.34; lat < 10.66; lat += 1.0 / 120) {
        const double on_lon = std::round(lon * 120) / 120, on_lat = std::round(lat * 120) / 120;
        CHECK(std::abs(height_at(sampler, on_lon, on_lat) -
                       (plane(on_lon, on_lat) + kOffset + hill(on_lon, on_lat))) <= 1.0);
      }
    }
    // Along a line through the rim, steps of a tenth of a post: never more than the offset over a fade.
    double before = height_at(sampler, 20.25, 10.5);
    for (double lon = 20.25; lon < 20.38; lon += 1.0 / 12000) {
      const double here = height_at(sampler, lon, 10.5);
      CHECK(std::abs(here - before) < 1);
      before = here;
    }
    // The fine raster's own posts are kept.
    CHECK(std::abs(height_at(sampler, 20.2, 10.2) - std::round(plane(20.2, 10.2))) <= 0.5);
    CHECK(std::abs(height_at(sampler, 20.298333333333333, 10.5) -
                   std::round(plane(20.298333333333333, 10.5))) <= 0.5);
  }
}

TEST_CASE("a void is filled up to a distance, and void farther in") {
  const test::TempDir dir;
  test::write_bytes(dir.path() / "N10E020.hgt", test::hgt_bytes(1201, fine_height));
  // A grid in UTM 34: 30 m posts, a void of 60 posts around its middle.
  test::TiffRecipe projected;
  projected.columns = projected.rows = 301;
  projected.pixel_scale = {30, 30, 0};
  projected.tiepoint = {0, 0, 0, 400000, 1200000, 0};
  projected.keys = {{1024, 1}, {1025, 2}, {3072, 32634}};
  projected.sample = [](int, std::int64_t column, std::int64_t row) {
    const bool hole = std::abs(column - 150) < 30 && std::abs(row - 150) < 30;
    return hole ? -32768.0 : static_cast<double>(500 + column + row);
  };
  test::write_tiff(dir.path() / "utm.tif", projected);
  constexpr double kDistance = 10;  // posts
  for (const char* dem : {"N10E020.hgt", "utm.tif"}) {
    BuildOptions options;
    options.mosaic.inputs = {dir.path() / dem};
    options.mosaic.void_posts = kDistance;
    options.session.target = dir.path() / "a.cairn";
    options.session.force = true;
    options.session.threads = 2;
    const auto report = build(options, [](const Progress&) { return true; });
    INFO((report.ok() ? "" : report.error().message));
    REQUIRE(report.ok());
    CHECK(verify_pack(options.session.target)->ok());
    auto pack = PackReader::open(options.session.target);
    REQUIRE(pack.ok());
    PackSampler sampler(*pack, 64);
    const auto has_height = [&](LonLat place) {
      const auto height = sampler.height_at(place);
      REQUIRE(height.ok());
      return height->has_value();
    };
    if (std::string(dem) == "N10E020.hgt") {
      // The void's first post is at 20.3 + 1/1200 or so; depth counts from the last one with a value.
      CHECK(has_height({20.3 + 8.0 / 1200, 10.5}));
      CHECK_FALSE(has_height({20.3 + 13.0 / 1200, 10.5}));
      CHECK_FALSE(has_height({20.5, 10.5}));
      CHECK(has_height({20.7 - 8.0 / 1200, 10.4}));
      CHECK_FALSE(has_height({20.7 - 13.0 / 1200, 10.4}));
      CHECK(has_height({20.2, 10.5}));
      continue;
    }
    const auto at = [](double columns_from_middle) {
      double lat = 0, lon = 0;
      GeographicLib::UTMUPS::Reverse(34, true, 400000 + 30 * (150 + columns_from_middle), 1200000 - 30 * 150,
                                     lat, lon);
      return LonLat{lon, lat};
    };
    CHECK(has_height(at(-31)));
    CHECK(has_height(at(-22)));
    CHECK(has_height(at(22)));
    CHECK_FALSE(has_height(at(-17)));
    CHECK_FALSE(has_height(at(0)));
    CHECK_FALSE(has_height(at(17)));
  }
}

}  // namespace cairn
