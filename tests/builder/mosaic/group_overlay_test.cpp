// Tiles of groups that lie over and beside one another: what two tiles share has the same bits in both.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "builder/mosaic/mosaic.h"
#include "tests/support/dem_files.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

namespace fs = std::filesystem;

constexpr int kTileSize = 257;

/// A raster of floats, by its north-western post.
struct Patch {
  double x = 0, y = 0, spacing = 1;
  int columns = 100, rows = 100;
  double turn = 0;  ///< degrees, anticlockwise
  double lift = 0;
  int void_every = 0;  ///< columns and rows with void posts in between; 0 for none
};

void write_patch(const fs::path& path, int epsg, const Patch& patch) {
  const bool geographic = epsg == 4326;
  const double a = patch.turn * M_PI / 180, c = patch.spacing * std::cos(a), s = patch.spacing * std::sin(a);
  TiffRecipe recipe;
  recipe.columns = patch.columns;
  recipe.rows = patch.rows;
  recipe.type = SampleType::float32;
  recipe.keys = {{1024, geographic ? 2 : 1}, {1025, 2}, {geographic ? 2048 : 3072, epsg}};
  recipe.pixel_scale.clear();
  recipe.tiepoint.clear();
  recipe.transformation = {c, s, 0, patch.x, s, -c, 0, patch.y, 0, 0, 0, 0, 0, 0, 0, 1};
  const double lift = patch.lift;
  const int period = patch.void_every;
  recipe.sample = [lift, period](int, std::int64_t column, std::int64_t row) {
    if (period > 0 && column % period > period * 2 / 3 && row % period > period / 2) return -9999.0;
    const auto u = static_cast<double>(column), v = static_cast<double>(row);
    const double noise = std::fmod(std::abs(std::sin(u * 12.9898 + v * 78.233) * 43758.5453), 1.0);
    return lift + 900 + 300 * std::sin(u / 7) * std::cos(v / 5) + 60 * noise;
  };
  write_tiff(path, recipe);
}

std::string bits(float height) {
  return std::isnan(height) ? "none" : std::to_string(height);
}

float height_of(const MosaicTile& tile, std::size_t sample) {
  const bool none = !tile.states.empty() && tile.states[sample] == SampleState::none;
  return none ? std::numeric_limits<float>::quiet_NaN() : tile.heights[sample];
}

// How many samples of the edge between a tile and its eastern or northern neighbour differ.
int differing(const Mosaic& mosaic, const TileId& id, bool east, std::string& where) {
  TileId other = id;
  ++(east ? other.x : other.y);
  const auto level = mosaic.leaf_level(id), beside = mosaic.leaf_level(other);
  if (level != id.level || beside != id.level) return 0;
  const auto here = mosaic.sample(id), there = mosaic.sample(other);
  REQUIRE(here.ok());
  REQUIRE(there.ok());
  int count = 0;
  for (int i = 0; i < kTileSize; ++i) {
    const auto mine =
        static_cast<std::size_t>(east ? i * kTileSize + kTileSize - 1 : (kTileSize - 1) * kTileSize + i);
    const auto its = static_cast<std::size_t>(east ? i * kTileSize : i);
    const float a = height_of(*here, mine), b = height_of(*there, its);
    if (std::memcmp(&a, &b, sizeof a) == 0) continue;
    if (++count <= 3)
      where += "\n  level " + std::to_string(id.level) + ", " + std::to_string(id.x) + "/" +
               std::to_string(id.y) + (east ? " east" : " north") + ", sample " + std::to_string(i) + ": " +
               bits(a) + " and " + bits(b);
  }
  return count;
}

void check(const char* layout, int epsg, const std::vector<Patch>& patches) {
  CAPTURE(layout, epsg);
  const TempDir folder;
  MosaicOptions options;
  for (std::size_t i = 0; i < patches.size(); ++i) {
    options.inputs.push_back(folder.path() / (std::to_string(i) + ".tif"));
    write_patch(options.inputs.back(), epsg, patches[i]);
  }
  const auto mosaic = Mosaic::open(options, kTileSize);
  REQUIRE(mosaic.ok());
  (*mosaic)->set_cache_bytes(std::size_t{64} << 20);
  for (std::size_t g = 0; g < (*mosaic)->groups().size(); ++g) (*mosaic)->set_tolerance(g, {0.039F});
  const GeoBounds bounds = (*mosaic)->bounds();
  int edges = 0, differ = 0;
  std::string where;
  int coarsest = (*mosaic)->finest_level();
  for (const auto& group : (*mosaic)->groups()) coarsest = std::min(coarsest, group->native_level());
  for (int level = coarsest; level <= (*mosaic)->finest_level(); ++level) {
    const double width = tile_width_degrees(level);
    const auto index = [width](double degrees) {
      return static_cast<std::int32_t>(std::floor(degrees / width));
    };
    for (std::int32_t y = index(bounds.south + 90); y <= index(bounds.north + 90); ++y)
      for (std::int32_t x = index(bounds.west + 180); x <= index(bounds.east + 180); ++x)
        for (const bool east : {false, true}) {
          if (!east && (y + 1) * width >= 180) continue;
          ++edges;
          differ += differing(**mosaic, TileId{level, x, y}, east, where);
        }
  }
  CHECK(edges > 0);
  INFO(where);
  CHECK(differ == 0);
}

// A place of the grid that the patches of `check` are on, in Switzerland.
Patch random_patch(std::mt19937& random, int epsg) {
  const auto between = [&](double least, double most) {
    return std::uniform_real_distribution<double>(least, most)(random);
  };
  const double unit = epsg == 4326 ? 1 / 4000.0 : 25;
  Patch patch;
  patch.spacing = unit * std::exp2(between(-0.8, 1.2));
  patch.x = (epsg == 4326 ? 7.44 : 2'600'000) + between(-60, 60) * unit;
  patch.y = (epsg == 4326 ? 46.95 : 1'200'000) + between(-60, 60) * unit;
  patch.columns = static_cast<int>(between(20, 90));
  patch.rows = static_cast<int>(between(20, 90));
  patch.turn = between(0, 1) < 0.5 ? 0 : between(-90, 90);
  patch.lift = between(-20, 20);
  patch.void_every = between(0, 1) < 0.5 ? 0 : static_cast<int>(between(6, 40));
  return patch;
}

}  // namespace

TEST_CASE("tiles share the samples of their edges whatever groups lie there") {
  std::mt19937 random(16);
  for (int i = 0; i < 12; ++i) {
    CAPTURE(i);
    const int epsg = i % 3 == 0 ? 4326 : 2056;
    std::vector<Patch> patches;
    for (int k = 0; k < 2 + i % 3; ++k) patches.push_back(random_patch(random, epsg));
    check("at random", epsg, patches);
  }
}

TEST_CASE("tiles share the samples of their edges where groups lie beside or upon one another") {
  for (const double turn : {0.0, 17.0}) {
    const double x = 2'600'000, y = 1'200'000, d = 25, side = 99;
    const Patch first{x, y, d, 100, 100, turn};
    check("half a post beside", 2056, {first, {x + (side + 1.5) * d, y + d / 2, d, 100, 100, turn}});
    check("finer beside", 2056, {first, {x + (side + 1) * d, y, d / 2, 200, 200, turn}});
    check("finer upon", 2056, {first, {x + 30 * d, y - 30 * d, d / 2, 90, 90, turn, 20}});
    check("turned otherwise upon", 2056, {{x + 20 * d, y - 40 * d, d, 60, 60, turn + 31, 5}, first});
  }
  // Beside a pole a degree of longitude is narrower than a post.
  for (const int side : {29, 30}) {
    const Patch polar{-100'000, -30'000, 300, 30, 30};
    check("half a post beside", 3413, {polar, {-100'000 + (side + 0.5) * 300, -30'150, 300, 30, 30}});
    check("finer beside", 3413, {polar, {-100'000 + side * 300.0, -30'000, 150, 60, 60}});
  }
  const double d = 1 / 1234.0;
  const Patch first{10.01, 50.02, d, 150, 150};
  check("half a post beside", 4326, {first, {10.01 + 150.5 * d, 50.02 + d / 2, d, 100, 100}});
  check("finer beside", 4326, {first, {10.01 + 150 * d, 50.02, d / 2, 200, 200}});
  check("finer upon", 4326, {first, {10.01 + 30.3 * d, 50.02 - 30.7 * d, d / 3, 190, 190, 0, 20}});
}

}  // namespace cairn::test
