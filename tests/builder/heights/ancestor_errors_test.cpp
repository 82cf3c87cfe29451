#include "builder/heights/ancestor_errors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

#include "builder/heights/geometric_error.h"

namespace cairn {
namespace {

constexpr int kSize = 65;
constexpr double kQuantum = 0.25;

// A rough surface with slopes and cliffs.
HeightTile rough_tile(std::mt19937& random, int roughness) {
  HeightTile tile{kSize, {}, {}};
  std::uniform_int_distribution<int> noise(-roughness, roughness);
  for (int r = 0; r < kSize; ++r) {
    for (int c = 0; c < kSize; ++c)
      tile.samples.push_back(40 * c - 25 * r + (c > 40 && r < 20 ? 900 : 0) + noise(random));
  }
  return tile;
}

// The surface of every `step`-th sample, at any place of the tile, written down anew: metres.
double surface(const HeightTile& tile, int step, double x, double y) {
  const int last = (kSize - 1) / step - 1;
  const int c = std::min(static_cast<int>(x / step), last), r = std::min(static_cast<int>(y / step), last);
  const double u = x / step - c, v = y / step - r;
  const auto at = [&](int i, int j) { return kQuantum * tile.at((c + i) * step, (r + j) * step); };
  return (1 - u) * (1 - v) * at(0, 0) + u * (1 - v) * at(1, 0) + (1 - u) * v * at(0, 1) + u * v * at(1, 1);
}

// Posts 0.6 samples apart or so, some void, each near the tile's surface.
MeasuredPosts posts_near(const HeightTile& tile, double spacing, double error_m, std::mt19937& random) {
  MeasuredPosts posts;
  std::uniform_real_distribution<double> off(-error_m, error_m);
  for (double at = 0.3; at <= kSize - 1; at += spacing) posts.xs.push_back(at);
  posts.ys = posts.xs;
  posts.ys.push_back(kSize - 1);
  for (const double y : posts.ys) {
    for (const double x : posts.xs) {
      const bool is_void = random() % 50 == 0;
      posts.heights.push_back(is_void ? std::numeric_limits<float>::quiet_NaN()
                                      : static_cast<float>(surface(tile, 1, x, y) + off(random)));
      posts.owners.push_back(1);
    }
  }
  return posts;
}

double worst_post(const HeightTile& tile, const MeasuredPosts& posts, int step) {
  double worst = 0;
  for (std::size_t j = 0; j < posts.ys.size(); ++j) {
    for (std::size_t i = 0; i < posts.xs.size(); ++i) {
      const double height = static_cast<double>(posts.heights[j * posts.xs.size() + i]);
      if (!std::isnan(height))
        worst = std::max(worst, std::abs(surface(tile, step, posts.xs[i], posts.ys[j]) - height));
    }
  }
  return worst;
}

// The posts one by one.
MeasuredPosts scattered(const MeasuredPosts& lattice) {
  MeasuredPosts posts;
  for (std::size_t j = 0; j < lattice.ys.size(); ++j) {
    for (std::size_t i = 0; i < lattice.xs.size(); ++i) {
      const float height = lattice.heights[j * lattice.xs.size() + i];
      if (!std::isnan(height)) posts.placed.push_back({lattice.xs[i], lattice.ys[j], height, 1});
    }
  }
  return posts;
}

double worst_sample(const HeightTile& tile, int step) {
  double worst = 0;
  for (int r = 0; r < kSize; ++r) {
    for (int c = 0; c < kSize; ++c)
      worst = std::max(worst, std::abs(surface(tile, step, c, r) - kQuantum * tile.at(c, r)));
  }
  return worst;
}

PostErrors own_errors(const HeightTile& tile, const MeasuredPosts& posts) {
  PostCounting counting;
  counting.window = {0, 0, kSize, kSize, 64};
  ErrorStats stats;
  PostErrors errors;
  measure_own_surface(tile, kQuantum, posts, counting, stats, errors);
  return errors;
}

}  // namespace

TEST_CASE("the errors of ancestors are those that looking at every post and sample finds") {
  std::mt19937 random(7);
  for (const int roughness : {0, 1, 30, 400}) {
    for (const double error_m : {0.0, 0.2, 60.0}) {
      for (const double spacing : {0.6, 1.0, 1.7, 9.1}) {
        const HeightTile tile = rough_tile(random, roughness);
        const std::vector<MeasuredPosts> posts{posts_near(tile, spacing, error_m, random)};
        const std::vector<MeasuredPosts> placed{scattered(posts.front())};
        const AncestorErrors errors(tile, kQuantum, posts, own_errors(tile, posts.front()));
        const AncestorErrors of_placed(tile, kQuantum, placed, own_errors(tile, placed.front()));
        for (int up = 1; up <= 6; ++up) {
          CAPTURE(roughness, error_m, spacing, up);
          const double of_posts = worst_post(tile, posts.front(), 1 << up);
          REQUIRE(of_placed.max_m(up) == errors.max_m(up));
          REQUIRE(of_placed.any_post_beyond(up, of_posts * 0.999 - 1e-6));
          REQUIRE_FALSE(of_placed.any_post_beyond(up, of_posts * 1.001 + 1e-6));
          REQUIRE(errors.max_m(up) ==
                  Approx(std::max(of_posts, worst_sample(tile, 1 << up))).epsilon(1e-9).margin(1e-9));
          REQUIRE(errors.any_post_beyond(up, of_posts * 0.999 - 1e-6));
          REQUIRE_FALSE(errors.any_post_beyond(up, of_posts * 1.001 + 1e-6));
        }
      }
    }
  }
}

TEST_CASE("one cliff among flat places is found at every level, wherever it is") {
  for (int place = 0; place < kSize * kSize; place += 37) {
    HeightTile tile{kSize, std::vector<std::int32_t>(std::size_t{kSize} * kSize, 100), {}};
    tile.samples[static_cast<std::size_t>(place)] = 3100;
    const AncestorErrors errors(tile, kQuantum, {}, PostErrors{});
    for (int up = 1; up <= 6; ++up) {
      CAPTURE(place, up);
      REQUIRE(errors.max_m(up) == worst_sample(tile, 1 << up));
    }
  }
}

TEST_CASE("the quick ways to measure a copy of its posts count what the slow way counts") {
  std::mt19937 random(3);
  const HeightTile tile = rough_tile(random, 50);
  MeasuredPosts posts;
  for (int i = 0; i < kSize; ++i) posts.xs.push_back(i);
  posts.ys = posts.xs;
  for (const std::int32_t sample : tile.samples)
    posts.heights.push_back(static_cast<float>(sample * kQuantum));
  posts.owners.assign(posts.heights.size(), 1);
  for (int sides = 0; sides < 16; ++sides) {
    PostCounting counting{{640, 1280, kSize, kSize, 64},
                          (sides & 1) != 0,
                          (sides & 2) != 0,
                          (sides & 4) != 0,
                          (sides & 8) != 0};
    ErrorStats slow, quick;
    measure_surface(tile, kQuantum, 0, posts, counting, slow);
    PostErrors errors;
    const SurfaceError own = measure_own_surface(tile, kQuantum, posts, counting, quick, errors);
    CAPTURE(sides);
    REQUIRE(own.max_m == 0);
    REQUIRE(errors.groups.empty());
    REQUIRE(quick.count() == slow.count());
    REQUIRE(quick.percentile(1) == 0);
    REQUIRE(counting.count(posts) == slow.count());
  }
  posts.heights[77] += 0.25F;
  PostCounting counting;
  counting.window = {0, 0, kSize, kSize, 64};
  ErrorStats stats;
  PostErrors errors;
  REQUIRE(measure_own_surface(tile, kQuantum, posts, counting, stats, errors).max_m == 0.25);
  REQUIRE(stats.max() == 0.25);
}

TEST_CASE("tiles with voids or impossible heights are not measured this way") {
  HeightTile tile{kSize, std::vector<std::int32_t>(std::size_t{kSize} * kSize, 0), {}};
  REQUIRE(AncestorErrors::can_measure(tile));
  tile.samples[5] = (1 << 24) + 1;
  REQUIRE_FALSE(AncestorErrors::can_measure(tile));
  tile.samples[5] = 0;
  tile.voids.assign(tile.samples.size(), 0);
  REQUIRE_FALSE(AncestorErrors::can_measure(tile));
}

TEST_CASE("a tile that overhangs 180 degrees leaves the posts beyond to the tile at 180 degrees west") {
  PostCounting counting;
  counting.window.columns = counting.window.rows = kSize;
  counting.antimeridian = 16;
  MeasuredPosts posts;
  posts.xs = {0, 7.5, 15.5, 16, 16.5, 40, 64};
  posts.ys = {0, 33, 64};
  for (const bool is_last : {false, true}) {
    counting.count_east = counting.count_north = counting.count_north_east = is_last;
    counting.count_north_west = is_last;
    std::uint64_t counted = 0;
    for (const double y : posts.ys)
      for (const double x : posts.xs) counted += counting.counts(x, y) ? 1 : 0;
    // With the line itself, and the northern edge, where no tile lies beyond.
    CHECK(counted == (is_last ? 4 * 3 : 3 * 2));
    CHECK(counting.count(posts) == counted);
  }
}

}  // namespace cairn
