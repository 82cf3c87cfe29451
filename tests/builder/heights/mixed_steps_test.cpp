// Sources of whole metres beside sources in fractions: each keeps an error bound of its own, and heights that
// whole metres alone decide cost no more bytes than without the others.

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "builder/raster/raster_pool.h"
#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "format/pack_verify.h"
#include "tests/support/dem_files.h"
#include "tests/support/test_bake.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

constexpr int kPosts = 1200;      // per degree, of the cells
constexpr int kFinePosts = 3600;  // per degree, of the patch
constexpr int kPatchSide = 361;   // posts
constexpr double kWest = 20.3, kNorth = 10.6;

double relief(double lon, double lat) {
  return 900 + 250 * std::sin(31 * lon) * std::cos(27 * lat) + 40 * std::sin(170 * lon + 90 * lat) +
         6 * std::sin(900 * lon) * std::sin(1100 * lat);
}

int metres_of_cell(int west, std::int64_t column, std::int64_t row) {
  return static_cast<int>(std::lround(
      relief(west + static_cast<double>(column) / kPosts, 11 - static_cast<double>(row) / kPosts)));
}

double metres_of_patch(std::int64_t column, std::int64_t row) {
  const double height = relief(kWest + static_cast<double>(column) / kFinePosts,
                               kNorth - static_cast<double>(row) / kFinePosts);
  return static_cast<float>(height + 0.3);
}

test::TiffRecipe float_patch() {
  test::TiffRecipe recipe;
  recipe.columns = recipe.rows = kPatchSide;
  recipe.type = SampleType::float32;
  recipe.pixel_scale = {1.0 / kFinePosts, 1.0 / kFinePosts, 0};
  recipe.tiepoint = {0, 0, 0, kWest, kNorth, 0};
  recipe.keys = {{1024, 2}, {1025, 2}, {2048, 4326}};
  recipe.sample = [](int, std::int64_t column, std::int64_t row) { return metres_of_patch(column, row); };
  return recipe;
}

void write_cells(const std::filesystem::path& folder) {
  for (const int west : {20, 21}) {
    test::write_bytes(folder / ("N10E0" + std::to_string(west) + ".hgt"),
                      test::hgt_bytes(kPosts + 1, [west](std::int64_t column, std::int64_t row) {
                        return metres_of_cell(west, column, row);
                      }));
  }
}

double error_at(PackSampler& sampler, double lon, double lat, double expected) {
  const auto height = sampler.height_at({lon, lat});
  REQUIRE(height.ok());
  REQUIRE(height->has_value());
  return std::abs((*height)->metres - expected);
}

// Degrees from a place to the patch, the larger of the two axes' distances.
double beyond_patch(double lon, double lat) {
  const double side = (kPatchSide - 1.0) / kFinePosts;
  return std::max({kWest - lon, lon - kWest - side, lat - kNorth, kNorth - side - lat, 0.0});
}

// Of the cells' posts that do not fade into the patch, and of the patch's.
std::pair<double, double> worst_errors(const PackReader& pack) {
  PackSampler sampler(pack, 64);
  double of_cells = 0, of_patch = 0;
  for (const int west : {20, 21})
    for (int row = 0; row <= kPosts; ++row)
      for (int column = 0; column <= kPosts; ++column) {
        const double lon = west + static_cast<double>(column) / kPosts;
        const double lat = 11 - static_cast<double>(row) / kPosts;
        if (beyond_patch(lon, lat) < 2.0 / kPosts) continue;
        of_cells = std::max(of_cells, error_at(sampler, lon, lat, metres_of_cell(west, column, row)));
      }
  for (int row = 0; row < kPatchSide; ++row)
    for (int column = 0; column < kPatchSide; ++column)
      of_patch = std::max(
          of_patch, error_at(sampler, kWest + static_cast<double>(column) / kFinePosts,
                             kNorth - static_cast<double>(row) / kFinePosts, metres_of_patch(column, row)));
  return {of_cells, of_patch};
}

// Of the heights' blocks east of 21°E.
std::uint64_t bytes_of_eastern_cell(const PackReader& pack, int finest) {
  std::uint64_t bytes = 0;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) {
    const IndexEntry entry = pack.entry(i);
    if (entry.layer == Layer::heights && entry.id.level == finest && tile_bounds(entry.id).west >= 21)
      bytes += entry.bytes;
  }
  return bytes;
}

}  // namespace

TEST_CASE("a patch in fractions of a metre leaves whole metres their error bound and their bytes", "[slow]") {
  const test::TempDir dir;
  write_cells(dir.path());
  test::write_tiff(dir.path() / "patch.tif", float_patch());
  const std::vector<std::filesystem::path> cells{dir.path() / "N10E020.hgt", dir.path() / "N10E021.hgt"};
  auto with_patch = cells;
  with_patch.push_back(dir.path() / "patch.tif");
  test::bake(test::bake_options(cells, dir.path() / "alone.cairn"));
  test::bake(test::bake_options(with_patch, dir.path() / "mixed.cairn"));

  const auto alone = PackReader::open(dir.path() / "alone.cairn");
  const auto mixed = PackReader::open(dir.path() / "mixed.cairn");
  REQUIRE(alone.ok());
  REQUIRE(mixed.ok());
  CHECK(verify_pack(dir.path() / "mixed.cairn")->ok());
  const auto [of_cells, of_patch] = worst_errors(*mixed);
  CHECK(of_cells <= 0.5);
  CHECK(of_cells > 0.1);  // whole metres are not met to centimetres
  CHECK(of_patch <= 0.05);

  const std::uint64_t before = bytes_of_eastern_cell(*alone, 2);
  REQUIRE(before > 100000);
  CHECK(static_cast<double>(bytes_of_eastern_cell(*mixed, 2)) < 1.01 * static_cast<double>(before));

  const auto metadata = nlohmann::json::parse(mixed->metadata_json());
  CHECK(metadata.at("error_bound_m") == 0.5);
  CHECK(metadata.at("least_error_bound_m") == 0.05);
  for (const auto& source : metadata.at("sources"))
    CHECK(source.at("error_bound_m") == (source.at("name") == "patch.tif" ? 0.05 : 0.5));
  CHECK_FALSE(nlohmann::json::parse(alone->metadata_json()).contains("least_error_bound_m"));
}

TEST_CASE("an error bound that is asked for holds for all sources, and one quantum for all heights",
          "[slow]") {
  const test::TempDir dir;
  write_cells(dir.path());
  test::write_tiff(dir.path() / "patch.tif", float_patch());
  auto options =
      test::bake_options({dir.path() / "N10E020.hgt", dir.path() / "N10E021.hgt", dir.path() / "patch.tif"},
                         dir.path() / "a.cairn");
  options.mosaic.max_error_m = 0.2;
  test::bake(options);
  const auto pack = PackReader::open(dir.path() / "a.cairn");
  REQUIRE(pack.ok());
  const auto [of_cells, of_patch] = worst_errors(*pack);
  CHECK(of_cells <= 0.2);
  CHECK(of_patch <= 0.2);
}

TEST_CASE("floats that hold whole metres are taken for whole metres, and a flat sea for nothing") {
  const test::TempDir dir;
  const auto open_with = [&](const std::function<double(std::int64_t, std::int64_t)>& height) {
    test::TiffRecipe recipe = float_patch();
    recipe.sample = [&](int, std::int64_t column, std::int64_t row) { return height(column, row); };
    test::write_tiff(dir.path() / "a.tif", recipe);
    const std::vector<std::filesystem::path> paths{dir.path() / "a.tif"};
    const auto pool = RasterPool::open(paths, {}, RasterPool::Content::heights);
    REQUIRE(pool.ok());
    return (*pool)->info(0).whole_metres;
  };
  CHECK(open_with([](std::int64_t c, std::int64_t r) { return std::round(metres_of_patch(c, r)); }));
  CHECK_FALSE(open_with(metres_of_patch));
  CHECK_FALSE(open_with([](std::int64_t, std::int64_t) { return 0.0; }));
  CHECK_FALSE(open_with([](std::int64_t c, std::int64_t r) { return c > 100 && r > 100 ? 12.5 : 0; }));
}

}  // namespace cairn
