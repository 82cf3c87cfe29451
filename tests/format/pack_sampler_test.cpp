#include "cairn/pack_sampler.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

constexpr double kQuantum = 0.25;  // test_header()'s

/// A bilinear surface, which bilinear sampling gives back exactly, whatever the tile's level.
std::int32_t tilted(std::int64_t column, std::int64_t row) {
  return static_cast<std::int32_t>(3 * column - 5 * row + 100000);
}
double tilted_metres(LonLat place, int finest) {
  const double scale = std::ldexp(256.0, finest);
  return (3 * (place.lon + 180) * scale - 5 * (place.lat + 90) * scale + 100000) * kQuantum;
}

const test::TestSurface kTilted{257, 2, tilted, {}};

PackReader open_pack(const test::TempDir& dir, const test::TestSurface& surface,
                     const std::vector<TileId>& tiles) {
  test::write_test_pack(dir.path() / "a.cairn", surface, tiles);
  Result<PackReader> reader = PackReader::open(dir.path() / "a.cairn");
  REQUIRE(reader.ok());
  return std::move(*reader);
}

std::optional<PackSampler::Height> sample(PackSampler& sampler, LonLat place,
                                          std::optional<int> level = std::nullopt) {
  const auto height = level ? sampler.height_at(place, *level, *level) : sampler.height_at(place);
  REQUIRE(height.ok());
  return *height;
}

}  // namespace

TEST_CASE("a surface that bilinear sampling keeps comes back at random places and levels") {
  const test::TempDir dir;
  const auto ids = test::with_ancestors({{2, 8, 4}, {2, 9, 5}, {2, 10, 6}, {2, 11, 7}}, -2);
  const PackReader reader = open_pack(dir, kTilted, ids);
  PackSampler sampler(reader, 2);
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> lon(-178, -177), lat(-89, -88);
  for (int i = 0; i < 500; ++i) {
    const LonLat place{lon(random), lat(random)};
    const auto height = sample(sampler, place);
    REQUIRE(height);
    CHECK(height->metres == Approx(tilted_metres(place, 2)).margin(1e-6));
    const bool fine = reader.find(Layer::heights, tile_at(place, 2)).has_value();
    CHECK((height->level == 2) == fine);
    const auto coarse = sample(sampler, place, -1);
    REQUIRE(coarse);
    CHECK(coarse->level == -1);
    CHECK((*sampler.height_at(place, 1, -2))->level ==
          (reader.find(Layer::heights, tile_at(place, 1)) ? 1 : 0));
    CHECK(coarse->metres == Approx(tilted_metres(place, 2)).margin(1e-6));
  }
}

TEST_CASE("a sampler's answer does not depend on what it was asked before") {
  const test::TempDir dir;
  const test::TestSurface surface{257, 2, test::hills, [](std::int64_t column, std::int64_t) {
                                    return column > 9 * 256 + 100 && column < 9 * 256 + 140;
                                  }};
  const PackReader reader =
      open_pack(dir, surface, test::with_ancestors({{2, 8, 4}, {2, 9, 5}, {2, 11, 7}}, -3));
  PackSampler asked(reader, 2);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> lon(-178.1, -176.9), lat(-89.1, -87.9), near(-1e-3, 1e-3);
  LonLat place{-177.5, -88.5};
  int there = 0;
  for (int i = 0; i < 1200; ++i) {
    switch (i % 4) {
      case 0:
        place = {lon(random), lat(random)};
        break;
      case 1:
        place = {std::round(place.lon * 8) / 8, place.lat};  // edges of tiles, and their corners below
        break;
      case 2:
        place = {place.lon, std::round(place.lat * 8) / 8};
        break;
      default:
        place = {place.lon + near(random), place.lat + near(random)};
    }
    const int finest = i % 3, coarsest = i % 5 == 0 ? finest : -3;
    PackSampler fresh(reader, 1);
    const auto found = asked.height_at(place, finest, coarsest);
    const auto expected = fresh.height_at(place, finest, coarsest);
    REQUIRE((found.ok() && expected.ok()));
    REQUIRE(found->has_value() == expected->has_value());
    if (!*found) continue;
    ++there;
    REQUIRE((*found)->metres == (*expected)->metres);
    REQUIRE((*found)->level == (*expected)->level);
    const auto entry = reader.find(Layer::heights, tile_at(place, (*found)->level));
    if (entry) REQUIRE((*found)->error_m == entry->geometric_error_m);
  }
  CHECK(there > 300);
}

TEST_CASE("the outer border of what was baked has heights, on every side and corner, and past it has none") {
  const test::TempDir dir;
  const PackReader reader = open_pack(dir, kTilted, {{2, 833, 507}});  // 28.25..28.5 E, 36.75..37 N
  PackSampler sampler(reader);
  for (const double lon : {28.25, 28.375, 28.5}) {
    for (const double lat : {36.75, 36.875, 37.0}) {
      for (const double noise : {0.0, -4e-15, 4e-15}) {
        const auto height = sample(sampler, {lon + noise, lat + noise});
        REQUIRE(height);
        CHECK(height->metres == Approx(tilted_metres({lon, lat}, 2)).margin(1e-5));
      }
    }
  }
  CHECK_FALSE(sample(sampler, {28.5 + 1e-6, 36.8}));
  CHECK_FALSE(sample(sampler, {28.3, 36.75 - 1e-6}));
  CHECK_FALSE(sample(sampler, {28.3, 36.8}, 1));
  CHECK_FALSE(sample(sampler, {28.3, 36.8}, 40));
  CHECK_FALSE(sample(sampler, {28.3, 36.8}, -40));
}

TEST_CASE("the antimeridian is one line from both sides, with overhanging tiles and without") {
  const test::TempDir dir;
  const test::TestSurface surface{257, 0, test::hills, {}};
  for (const int level : {-9, -6, -4, -3, 0}) {
    const std::int32_t last = tiles_around(level) - 1;
    const TileId west{level, 0, tile_at({0, 10}, level).y}, east{level, last, west.y};
    const double expected =
        test::hills(0, (10 + 90) * 256) * kQuantum;  // 10 N is a sample at every level tested
    for (const auto& ids : {std::vector{west}, std::vector{east}}) {
      const PackReader reader = open_pack(dir, surface, ids);
      PackSampler sampler(reader);
      for (const double lon : {180.0, -180.0, 540.0, 180 - 1e-14}) {
        const auto height = sample(sampler, {lon, 10.0});
        INFO("level " << level << " lon " << lon);
        REQUIRE(height);
        if (level >= -3) CHECK(height->metres == Approx(expected).margin(1e-3));
      }
    }
  }
}

TEST_CASE("the poles have heights and what lies past them has none") {
  const test::TempDir dir;
  const PackReader reader = open_pack(dir, kTilted, {{2, 10, 719}, {2, 10, 0}});
  PackSampler sampler(reader);
  const double lon = -177.4;
  CHECK(sample(sampler, {lon, 90.0}));
  CHECK(sample(sampler, {lon, -90.0}));
  CHECK_FALSE(sample(sampler, {lon, 90.1}));
  CHECK_FALSE(sample(sampler, {lon, -91}));
  CHECK_FALSE(sample(sampler, {std::nan(""), 0}));
  CHECK_FALSE(sample(sampler, {0, std::nan("")}));
  CHECK_FALSE(sample(sampler, {INFINITY, 0}));
}

TEST_CASE("a void swallows the places that need it and no others") {
  const test::TempDir dir;
  // One void sample in the middle of the tile: column 2048+100, row 1024+100 of the grid of level 2.
  const test::TestSurface surface{257, 2, tilted,
                                  [](auto c, auto r) { return c == 2048 + 100 && r == 1024 + 100; }};
  const PackReader reader = open_pack(dir, surface, {{2, 8, 4}});
  PackSampler sampler(reader);
  const auto at = [&](double column, double row) {
    return sample(sampler, {-178 + column / 1024, -89 + row / 1024}).has_value();
  };
  CHECK_FALSE(at(100, 100));
  CHECK_FALSE(at(99.5, 100));
  CHECK_FALSE(at(100.9, 100.9));
  CHECK(at(99, 100));
  CHECK(at(101, 100.5));
  CHECK(at(99, 99));
}

TEST_CASE("a damaged tile is an error, not a missing height") {
  const test::TempDir dir;
  const auto path = dir.path() / "a.cairn";
  test::write_test_pack(path, kTilted, {{2, 8, 4}});
  auto bytes = test::read_bytes(path);
  bytes[kPackStartBytes + 50] ^= std::byte{1};
  test::write_bytes(path, bytes);
  const auto reader = PackReader::open(path);
  REQUIRE(reader.ok());
  PackSampler sampler(*reader);
  const auto height = sampler.height_at({-177.9, -88.9});
  REQUIRE_FALSE(height.ok());
  CHECK(height.error().code == ErrorCode::bad_data);
}

}  // namespace cairn
