#include "builder/resample/resample_lattice.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

struct Field {
  IndexWindow window;
  std::vector<float> heights;

  float at(std::int64_t x, std::int64_t y) const { return heights[window.offset(x, y)]; }
};

Field random_posts(IndexWindow window, float most, unsigned seed) {
  Field field{window, {}};
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> height(-430, most);
  for (std::int64_t i = 0; i < window.count(); ++i) field.heights.push_back(height(random));
  return field;
}

Field part_of(const Field& whole, IndexWindow window) {
  Field part{window, {}};
  for (std::int64_t y = window.y.first; y <= window.y.last; ++y) {
    for (std::int64_t x = window.x.first; x <= window.x.last; ++x) part.heights.push_back(whole.at(x, y));
  }
  return part;
}

Field resampled(const AxisResampler& x, const AxisResampler& y, const Field& posts, IndexWindow window) {
  Field out{window, std::vector<float>(static_cast<std::size_t>(window.count()))};
  resample_lattice(x, y, posts.window, posts.heights, window, out.heights);
  return out;
}

double surface_at(const Field& samples, double x, double y) {
  const auto i = static_cast<std::int64_t>(std::floor(x));
  const auto j = static_cast<std::int64_t>(std::floor(y));
  const double s = x - std::floor(x);
  const double t = y - std::floor(y);
  double sum = 0;
  if (s < 1 && t < 1) sum += (1 - s) * (1 - t) * static_cast<double>(samples.at(i, j));
  if (s > 0) sum += s * (1 - t) * static_cast<double>(samples.at(i + 1, j));
  if (t > 0) sum += (1 - s) * t * static_cast<double>(samples.at(i, j + 1));
  if (s > 0 && t > 0) sum += s * t * static_cast<double>(samples.at(i + 1, j + 1));
  return sum;
}

}  // namespace

TEST_CASE("the bilinear surface of float samples meets every post of 9000 m of noise within a millimetre") {
  struct Case {
    LatticeAxis x, y;
    double samples;
  };
  for (const Case& c : {Case{{1200, 0}, {1200, 0}, 2048}, Case{{3600, 0}, {3600, 0}, 4096},
                        Case{{1200, 0.5}, {1200, 0.5}, 1280}, Case{{600, 0}, {1200, 0}, 2048},
                        Case{{1192.137, 0.31}, {1192.14, 0.77}, 2048}, Case{{12, 0}, {12, 0}, 256}}) {
    const AxisResampler x(c.x, c.samples, ResampleMethod::exact);
    const AxisResampler y(c.y, c.samples, ResampleMethod::exact);
    const auto east = static_cast<std::int64_t>(208.4 * c.samples);
    const auto north = static_cast<std::int64_t>(126.6 * c.samples);
    const IndexWindow window{{east, east + 255}, {north, north + 200}};
    const Field posts = random_posts({x.posts_for(window.x), y.posts_for(window.y)}, 9000, 1);
    const Field samples = resampled(x, y, posts, window);
    const AxisPositions at_x(c.x, c.samples), at_y(c.y, c.samples);
    double worst = 0;
    std::int64_t met = 0;
    for (std::int64_t i = posts.window.y.first; i <= posts.window.y.last; ++i) {
      for (std::int64_t k = posts.window.x.first; k <= posts.window.x.last; ++k) {
        const double px = at_x.position(k);
        const double py = at_y.position(i);
        if (px < static_cast<double>(east) || px > static_cast<double>(window.x.last)) continue;
        if (py < static_cast<double>(north) || py > static_cast<double>(window.y.last)) continue;
        worst = std::max(worst, std::abs(surface_at(samples, px, py) - static_cast<double>(posts.at(k, i))));
        ++met;
      }
    }
    CAPTURE(c.x.posts_per_degree, c.samples, met);
    CHECK(met > 100);
    CHECK(worst < 1e-3);
  }
}

TEST_CASE("a sample has the same bits in every window of samples and of posts") {
  std::mt19937 random(9);
  for (const LatticeAxis axis : {LatticeAxis{1200, 0}, LatticeAxis{1900, 0.4}, LatticeAxis{12, 0.5}}) {
    const AxisResampler r(axis, 2048, ResampleMethod::exact);
    const IndexWindow window{{40960, 41160}, {81920, 82100}};
    const Field posts = random_posts({r.posts_for(window.x), r.posts_for(window.y)}, 3000, 4);
    const Field whole = resampled(r, r, posts, window);
    const auto pick = [&random](IndexRange range) {
      const auto a = std::uniform_int_distribution<std::int64_t>(range.first, range.last)(random);
      return IndexRange{a, std::uniform_int_distribution<std::int64_t>(a, range.last)(random)};
    };
    for (int i = 0; i < 25; ++i) {
      const IndexWindow part{pick(window.x), pick(window.y)};
      const Field few = part_of(posts, {r.posts_for(part.x), r.posts_for(part.y)});
      REQUIRE(resampled(r, r, few, part).heights == part_of(whole, part).heights);
    }
  }
}

TEST_CASE("constants and planes are reproduced") {
  for (const LatticeAxis axis : {LatticeAxis{1200, 0}, LatticeAxis{3600, 0.25}}) {
    const AxisResampler r(axis, 4096, ResampleMethod::exact);
    const IndexWindow window{{1000, 1099}, {2000, 2099}};
    Field posts = random_posts({r.posts_for(window.x), r.posts_for(window.y)}, 1, 1);
    std::fill(posts.heights.begin(), posts.heights.end(), 8848.86f);
    for (float h : resampled(r, r, posts, window).heights) REQUIRE(h == 8848.86f);
    const AxisPositions at(axis, 4096);
    for (std::int64_t y = posts.window.y.first; y <= posts.window.y.last; ++y) {
      for (std::int64_t x = posts.window.x.first; x <= posts.window.x.last; ++x) {
        posts.heights[posts.window.offset(x, y)] =
            static_cast<float>(3 * at.position(x) - 0.5 * at.position(y));
      }
    }
    const Field plane = resampled(r, r, posts, window);
    for (std::int64_t y = 2000; y < 2100; ++y) {
      for (std::int64_t x = 1000; x < 1100; ++x) {
        REQUIRE(static_cast<double>(plane.at(x, y)) ==
                Approx(3.0 * static_cast<double>(x) - 0.5 * static_cast<double>(y)).margin(1e-3));
      }
    }
  }
}

TEST_CASE("samples on a whole degree depend on the posts of that line only") {
  const AxisResampler r({1200, 0}, 2048, ResampleMethod::exact);
  const IndexWindow window{{208 * 2048, 208 * 2048}, {126 * 2048 - 50, 126 * 2048 + 50}};
  CHECK(r.posts_for(window.x) == IndexRange{208 * 1200, 208 * 1200});
  const IndexRange rows = r.posts_for(window.y);
  const Field wide = random_posts({{208 * 1200 - 3, 208 * 1200 + 3}, rows}, 4000, 8);
  const Field line = part_of(wide, {{208 * 1200, 208 * 1200}, rows});
  CHECK(resampled(r, r, wide, window).heights == resampled(r, r, line, window).heights);
}

TEST_CASE("posts on the samples are handed on untouched") {
  const AxisResampler r({4096, 0}, 4096, ResampleMethod::exact);
  const IndexWindow window{{300, 400}, {500, 577}};
  CHECK(r.posts_for(window.x) == window.x);
  const Field posts = random_posts(window, 9000, 6);
  CHECK(resampled(r, r, posts, window).heights == posts.heights);
}

TEST_CASE("nearest takes the nearer post and bilinear weighs both") {
  const AxisResampler nearest({1, 0}, 4, ResampleMethod::nearest);
  const AxisResampler bilinear({1, 0}, 4, ResampleMethod::bilinear);
  const Field posts{{{0, 1}, {0, 0}}, {100, 200}};
  const IndexWindow window{{0, 4}, {0, 0}};
  CHECK(resampled(nearest, nearest, posts, window).heights == std::vector<float>{100, 100, 200, 200, 200});
  CHECK(resampled(bilinear, bilinear, posts, window).heights == std::vector<float>{100, 125, 150, 175, 200});
}

}  // namespace cairn
