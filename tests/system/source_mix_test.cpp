// Bakes of sources that go together in ways that once went wrong.

#include <cmath>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "cairn/bake_estimate.h"
#include "cairn/build.h"
#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "format/pack_verify.h"
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

// A raster of floats in lat/long that holds `height`; posts at the places of a pixel-is-area file whose
// north-western corner is given, or of a pixel-is-point one whose first post that is.
struct Sheet {
  double west = 0, north = 0;
  double per_lon = 1, per_lat = 1;  // posts a degree
  int columns = 0, rows = 0;
  bool area = false;

  LonLat place(int column, int row) const {
    const double half = area ? 0.5 : 0;
    return {west + (column + half) / per_lon, north - (row + half) / per_lat};
  }
};

template <class Height>
void write_sheet(const fs::path& path, const Sheet& sheet, const Height& height) {
  TiffRecipe recipe = lattice(sheet.west, sheet.north, 1, sheet.columns, sheet.rows);
  recipe.type = SampleType::float32;
  recipe.keys[1025] = sheet.area ? 1 : 2;
  recipe.pixel_scale = {1 / sheet.per_lon, 1 / sheet.per_lat, 0};
  recipe.sample = [&](int, std::int64_t column, std::int64_t row) {
    return height(sheet.place(static_cast<int>(column), static_cast<int>(row)));
  };
  write_tiff(path, recipe);
}

// How far the pack is from the heights at the sheet's posts, at most, of those that `counts` accepts.
template <class Height, class Counts>
double worst_at_posts(PackSampler& sampler, const Sheet& sheet, const Height& height, const Counts& counts) {
  double worst = 0;
  for (int row = 0; row < sheet.rows; ++row) {
    for (int column = 0; column < sheet.columns; ++column) {
      const LonLat place = sheet.place(column, row);
      if (!counts(place)) continue;
      const auto found = sampler.height_at(place);
      REQUIRE(found.ok());
      REQUIRE(found->has_value());
      worst = std::max(worst, std::abs((*found)->metres - height(place)));
    }
  }
  return worst;
}

bool everywhere(LonLat) {
  return true;
}

double waves(LonLat p) {
  return 700 + 300 * std::sin(p.lon * 40) * std::cos(p.lat * 35) + 80 * std::sin(p.lon * 170 + p.lat * 130);
}

// 30° steep, eastwards.
double slope(LonLat p) {
  return 1500 + (p.lon - 6) * 78'600 * 0.57735;
}

PackReader baked(const std::vector<fs::path>& files, const fs::path& target, double fade = 1) {
  BuildOptions options = bake_options(files, target);
  options.mosaic.fade_posts = fade;
  bake(options);
  const auto verified = verify_pack(target, {2, 10});
  REQUIRE(verified.ok());
  for (const Finding& f : verified->findings) UNSCOPED_INFO(f.where << ": " << f.what);
  CHECK(verified->ok());
  auto pack = PackReader::open(target);
  REQUIRE(pack.ok());
  return std::move(*pack);
}

nlohmann::json sources_of(const PackReader& pack) {
  return nlohmann::json::parse(pack.metadata_json()).at("sources");
}

}  // namespace

TEST_CASE("rasters of different spacing that touch keep every post of both") {
  const TempDir folder;
  const fs::path a = folder.path() / "a.tif", b = folder.path() / "b.tif";
  struct Pair {
    Sheet south, north;
  };
  for (const Pair& pair :
       {// Copernicus GLO-30 at 50°: the southern tile's last row lies on the parallel.
        Pair{{10, 50, 360, 360, 300, 120}, {10, 50.5, 240, 360, 200, 180}},
        // Pixels that touch: the posts on both sides lie half a pixel off the line.
        Pair{{10, 50, 300, 300, 200, 150, true}, {10, 50.5, 200, 200, 140, 100, true}},
        Pair{{10, 50.0123, 300, 300, 200, 150, true}, {10, 50.5123, 290, 310, 200, 155, true}},
        // Cells that share a row, as DTED's do where the spacing changes.
        Pair{{10, 50, 300, 300, 200, 150}, {10, 50.4, 150, 300, 100, 121}}}) {
    for (const bool south_first : {true, false}) {
      write_sheet(a, pair.south, waves);
      write_sheet(b, pair.north, waves);
      const std::vector<fs::path> files = south_first ? std::vector{a, b} : std::vector{b, a};
      const PackReader pack = baked(files, folder.path() / "o.cairn");
      PackSampler sampler(pack, 64);
      INFO(pair.north.north << " " << south_first);
      CHECK(worst_at_posts(sampler, pair.south, waves, everywhere) <= 0.05);
      CHECK(worst_at_posts(sampler, pair.north, waves, everywhere) <= 0.05);
    }
  }
}

TEST_CASE("sources that agree leave no step, and those that do not a ramp of the width asked for") {
  const TempDir folder;
  const fs::path fine_path = folder.path() / "fine.tif", coarse_path = folder.path() / "coarse.tif";
  const Sheet coarse{5.9, 45.1, 300, 300, 60, 60, true}, fine{6.000012, 45.05, 900, 900, 60, 60, true};
  const auto surface_at = [](PackSampler& sampler, double lon) {
    const auto found = sampler.height_at({lon, 45.02});
    REQUIRE(found.ok());
    REQUIRE(found->has_value());
    return (*found)->metres;
  };
  write_sheet(coarse_path, coarse, slope);
  write_sheet(fine_path, fine, slope);
  {
    const PackReader pack = baked({coarse_path, fine_path}, folder.path() / "o.cairn");
    PackSampler sampler(pack, 64);
    for (double lon = 5.97; lon < 6.06; lon += 0.00011)
      CHECK(std::abs(surface_at(sampler, lon) - slope({lon, 45.02})) < 0.5);
  }
  write_sheet(fine_path, fine, [](LonLat p) { return slope(p) + 20; });
  for (const double fade : {1.0, 4.0}) {
    const PackReader pack = baked({fine_path, coarse_path}, folder.path() / "o.cairn", fade);
    PackSampler sampler(pack, 64);
    const double rim = fine.place(0, 0).lon, width = fade / coarse.per_lon;
    CHECK(surface_at(sampler, rim + 0.001) - slope({rim + 0.001, 0}) == Approx(20).margin(0.5));
    CHECK(surface_at(sampler, rim - width / 2) - slope({rim - width / 2, 0}) == Approx(10).margin(2));
    CHECK(surface_at(sampler, rim - 1.3 * width) - slope({rim - 1.3 * width, 0}) == Approx(0).margin(0.5));
    const auto is_outside = [&](LonLat p) {
      return std::max({rim - p.lon, fine.place(0, 59).lat - p.lat, p.lat - fine.place(0, 0).lat,
                       p.lon - fine.place(59, 0).lon}) > width;
    };
    CHECK(worst_at_posts(sampler, coarse, slope, is_outside) <= 0.05);
    CHECK(worst_at_posts(
              sampler, fine, [](LonLat p) { return slope(p) + 20; }, everywhere) <= 0.05);
  }
}

TEST_CASE("posts that lose where sources overlap are counted, each post once") {
  const TempDir folder;
  const fs::path fine_path = folder.path() / "fine.tif", coarse_path = folder.path() / "coarse.tif";
  const Sheet coarse{5.9, 45.1, 300, 300, 60, 60, true}, fine{6.000012, 45.05, 900, 900, 60, 60, true};
  write_sheet(coarse_path, coarse, waves);
  write_sheet(fine_path, fine, waves);
  const auto sources = sources_of(baked({fine_path, coarse_path}, folder.path() / "o.cairn"));
  CHECK(sources[0]["posts_used"] == 3600);
  CHECK(sources[0]["posts_lost"] == 0);
  CHECK(sources[1]["posts_used"].get<int>() + sources[1]["posts_lost"].get<int>() == 3600);
  CHECK(sources[1]["posts_lost"].get<int>() >= 20 * 20);
  CHECK(sources[1]["posts_lost"].get<int>() <= 24 * 24);
}

TEST_CASE("the order of the command line decides between equals, a priority between any") {
  const TempDir folder;
  const fs::path a = folder.path() / "a.tif", b = folder.path() / "b.tif";
  const Sheet first{10, 50, 300, 300, 60, 60}, second{10.1, 50, 297, 297, 60, 60};
  write_sheet(a, first, [](LonLat) { return 100.0; });
  write_sheet(b, second, [](LonLat) { return 200.0; });
  const auto height = [&](const BuildOptions& options) {
    bake(options);
    auto pack = PackReader::open(options.session.target);
    REQUIRE(pack.ok());
    PackSampler sampler(*pack, 8);
    return (*sampler.height_at({10.15, 49.9}))->metres;
  };
  const fs::path target = folder.path() / "o.cairn";
  CHECK(height(bake_options({a, b}, target)) == Approx(100));
  CHECK(height(bake_options({b, a}, target)) == Approx(200));
  BuildOptions told = bake_options({a, b}, target);
  told.mosaic.source_rules = {{"b.tif", {.priority = 1}}};
  CHECK(height(told) == Approx(200));
  // Also over a source that is much finer, and on its own grid.
  const Sheet coarse{9.95, 50.05, 60, 60, 30, 30};
  write_sheet(b, coarse, [](LonLat) { return 200.0; });
  CHECK(height(bake_options({a, b}, target)) == Approx(100));
  CHECK(height(told) == Approx(200));
  write_sheet(b, first, [](LonLat) { return 200.0; });
  CHECK(height(bake_options({a, b}, target)) == Approx(100));
  CHECK(height(told) == Approx(200));
}

TEST_CASE("voids of a projected raster show what lies beneath, faded from their rims") {
  const TempDir folder;
  const fs::path fine = folder.path() / "utm.tif", coarse = folder.path() / "coarse.tif";
  // 30 m in UTM 32 around 9°E 45°N, 100 m above a level coarse raster; a void of 60 posts square amid it.
  TiffRecipe utm;
  utm.columns = utm.rows = 160;
  utm.type = SampleType::float32;
  utm.keys = {{1024, 1}, {1025, 2}, {3072, 32632}};
  utm.pixel_scale = {30, 30, 0};
  utm.tiepoint = {0, 0, 0, 500000 - 80 * 30, 4983000 + 80 * 30, 0};
  utm.sample = [](int, std::int64_t c, std::int64_t r) {
    return c >= 50 && c < 110 && r >= 50 && r < 110 ? -9999.0 : 600.0;
  };
  write_tiff(fine, utm);
  const Sheet sheet{8.9, 45.1, 1200, 1200, 240, 240};
  write_sheet(coarse, sheet, [](LonLat) { return 500.0; });
  const PackReader pack = baked({fine, coarse}, folder.path() / "o.cairn");
  PackSampler sampler(pack, 64);
  const auto height = [&](double east_m) {
    const auto found = sampler.height_at({9 + east_m / 78'850, 44.9995});
    REQUIRE(found.ok());
    REQUIRE(found->has_value());
    return (*found)->metres;
  };
  CHECK(height(0) == Approx(500).margin(0.1));      // amid the void
  CHECK(height(-1500) == Approx(600).margin(0.1));  // beside it
  CHECK(height(29 * 30 + 45) == Approx(600).margin(0.1));
  double before = height(29 * 30 + 45);
  for (double east = 29 * 30 + 40; east > 0; east -= 5) {  // no cliff from the rim inwards
    const double here = height(east);
    CHECK(here <= before + 0.1);
    CHECK(before - here < 12);
    before = here;
  }
}

TEST_CASE("a region of a fine DEM over one of the whole Earth is baked") {
  const TempDir folder;
  const fs::path world = folder.path() / "world.tif", fine = folder.path() / "fine.tif";
  write_tiff(world, lattice(-180, 90, 4, 1440, 721));
  write_tiff(fine, lattice(121, 25, 600, 601, 601));
  BuildOptions options = bake_options({fine, world}, folder.path() / "o.cairn");
  for (const GeoBounds& region :
       {GeoBounds{117, 21, 125, 27}, GeoBounds{121.25, 24.25, 121.5, 24.5}, GeoBounds{122, 24, 123, 25},
        GeoBounds{-10, -10, 10, 10}, GeoBounds{120.7, 24.9, 121.4, 25.3}, GeoBounds{121.5, 23, 150, 24.6}}) {
    options.grid.region = region;
    INFO(region.west << " " << region.south);
    REQUIRE(dry_run(options).ok());
    bake(options);
    const auto verified = verify_pack(options.session.target, {2, 10});
    REQUIRE(verified.ok());
    for (const Finding& f : verified->findings) UNSCOPED_INFO(f.where << ": " << f.what);
    CHECK(verified->ok());
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
