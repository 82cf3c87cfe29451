#include "builder/resample/smooth_lattice.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

struct Field {
  IndexWindow window;
  std::vector<float> heights;

  float at(std::int64_t x, std::int64_t y) const { return heights[window.offset(x, y)]; }
};

using Relief = std::function<double(std::int64_t, std::int64_t)>;  // a height for each post of a lattice

struct Grid {
  LatticeAxis axis;
  double samples_per_degree;

  AxisPositions positions() const { return {axis, samples_per_degree}; }
};

const std::vector<Grid>& grids() {
  static const std::vector<Grid> all{{{1200, 0}, 2048},   {{3600, 0}, 4096},        {{1200, 0.5}, 1280},
                                     {{600, 0}, 2048},    {{1192.137, 0.31}, 2048}, {{12, 0}, 256},
                                     {{1975, 0.4}, 2048}, {{2048, 0}, 4096},        {{900, 0.5}, 8192}};
  return all;
}

constexpr SmoothTolerance kWholeMetres{0.25, 0.25};

Field smoothed(const Grid& gx, const Grid& gy, const Relief& relief, IndexWindow window,
               const SmoothTolerance& tolerance = kWholeMetres) {
  const SmoothAxis x(gx.positions(), window.x);
  const SmoothAxis y(gy.positions(), window.y);
  std::vector<float> posts;
  for (std::int64_t j = y.posts.first; j <= y.posts.last; ++j) {
    for (std::int64_t i = x.posts.first; i <= x.posts.last; ++i)
      posts.push_back(static_cast<float>(relief(i, j)));
  }
  Field out{window, std::vector<float>(static_cast<std::size_t>(window.count()))};
  smooth_lattice(x, y, tolerance, posts, window, out.heights);
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

IndexWindow window_of(const Grid& gx, const Grid& gy, std::int64_t columns, std::int64_t rows) {
  const auto east = static_cast<std::int64_t>(208.4 * gx.samples_per_degree);
  const auto north = static_cast<std::int64_t>(126.6 * gy.samples_per_degree);
  return {{east, east + columns - 1}, {north, north + rows - 1}};
}

// Calls with each post inside the window and its place.
void for_each_post(const Grid& gx, const Grid& gy, IndexWindow window,
                   const std::function<void(std::int64_t, std::int64_t, double, double)>& see) {
  const AxisPositions x = gx.positions();
  const AxisPositions y = gy.positions();
  for (std::int64_t j = y.first_post_from(window.y.first);
       y.position(j) <= static_cast<double>(window.y.last); ++j) {
    for (std::int64_t i = x.first_post_from(window.x.first);
         x.position(i) <= static_cast<double>(window.x.last); ++i)
      see(i, j, x.position(i), y.position(j));
  }
}

// The same number for a post whoever asks, spread evenly over 0 … 1.
double noise(std::int64_t i, std::int64_t j, std::uint64_t seed) {
  std::uint64_t h = static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15U +
                    static_cast<std::uint64_t>(j) * 0xC2B2AE3D27D4EB4FU + seed;
  h = (h ^ (h >> 29)) * 0xBF58476D1CE4E5B9U;
  h = (h ^ (h >> 32)) * 0x94D049BB133111EBU;
  return static_cast<double>((h ^ (h >> 29)) >> 11) * 0x1p-53;
}

struct NamedRelief {
  const char* name;
  Relief height;
};

std::vector<NamedRelief> hard_reliefs() {
  return {{"white noise of 9000 m", [](auto i, auto j) { return 9000 * noise(i, j, 1); }},
          {"checkerboard of 1000 m", [](auto i, auto j) { return (i + j) % 2 == 0 ? 1000.0 : -1000.0; }},
          {"whole metres of noise", [](auto i, auto j) { return std::floor(3 * noise(i, j, 2)); }},
          {"cliffs over water",
           [](auto i, auto j) { return (i / 7 + j / 5) % 3 == 0 ? 0.0 : std::floor(300 * noise(i, j, 3)); }},
          {"single peaks", [](auto i, auto j) { return noise(i, j, 4) < 0.05 ? 500.0 : 0.0; }},
          {"hills in whole metres", [](auto i, auto j) {
             return std::round(40 * std::sin(0.11 * static_cast<double>(i)) +
                               30 * std::cos(0.07 * static_cast<double>(j)));
           }}};
}

}  // namespace

TEST_CASE("the smooth surface is within the interval of every post, whatever the relief", "[slow]") {
  for (const Grid& gx : grids()) {
    const Grid& gy = gx.axis.posts_per_degree == 600 ? grids().front() : gx;
    const IndexWindow window = window_of(gx, gy, 230, 210);
    for (const NamedRelief& relief : hard_reliefs()) {
      for (const SmoothTolerance tolerance :
           {kWholeMetres, SmoothTolerance{0, 0.25}, SmoothTolerance{0.024, 0.025}}) {
        const Field samples = smoothed(gx, gy, relief.height, window, tolerance);
        double worst = 0;
        std::int64_t met = 0;
        for_each_post(gx, gy, window, [&](auto i, auto j, double px, double py) {
          const auto post = static_cast<double>(static_cast<float>(relief.height(i, j)));
          worst = std::max(worst, std::abs(surface_at(samples, px, py) - post));
          ++met;
        });
        CAPTURE(relief.name, gx.axis.posts_per_degree, gx.samples_per_degree, tolerance.interval_m);
        CHECK(met > 80);
        CHECK(worst < tolerance.interval_m + 1e-3);
      }
    }
  }
}

TEST_CASE("a smooth sample has the same bits in every window") {
  std::mt19937 random(9);
  for (const Grid& grid : grids()) {
    for (const NamedRelief& relief : hard_reliefs()) {
      const IndexWindow window = window_of(grid, grid, 201, 181);
      const Field whole = smoothed(grid, grid, relief.height, window);
      const auto pick = [&random](IndexRange range) {
        const auto a = std::uniform_int_distribution<std::int64_t>(range.first, range.last)(random);
        return IndexRange{a, std::uniform_int_distribution<std::int64_t>(a, range.last)(random)};
      };
      for (int n = 0; n < 8; ++n) {
        const IndexWindow part{pick(window.x), pick(window.y)};
        const Field small = smoothed(grid, grid, relief.height, part);
        bool equal = true;
        for (std::int64_t y = part.y.first; y <= part.y.last; ++y) {
          for (std::int64_t x = part.x.first; x <= part.x.last; ++x)
            equal = equal && small.at(x, y) == whole.at(x, y);
        }
        CAPTURE(relief.name, grid.axis.posts_per_degree, grid.samples_per_degree);
        REQUIRE(equal);
      }
    }
  }
}

TEST_CASE("smooth samples on a whole degree depend on the posts of that line only") {
  const Grid grid{{1200, 0}, 2048};
  const IndexWindow window{{208 * 2048, 208 * 2048}, {126 * 2048 - 50, 126 * 2048 + 50}};
  const SmoothAxis x(grid.positions(), window.x);
  CHECK(x.posts == IndexRange{208 * 1200, 208 * 1200});
  const IndexWindow wide{{208 * 2048 - 30, 208 * 2048 + 30}, window.y};
  for (const NamedRelief& relief : hard_reliefs()) {
    CAPTURE(relief.name);
    const Field line = smoothed(grid, grid, relief.height, window);
    const Field area = smoothed(grid, grid, relief.height, wide);
    for (std::int64_t y = window.y.first; y <= window.y.last; ++y)
      REQUIRE(area.at(208 * 2048, y) == line.at(208 * 2048, y));
  }
}

TEST_CASE("constants stay what they are, planes nearly so, and posts on samples are handed on") {
  for (const Grid& grid : grids()) {
    CAPTURE(grid.axis.posts_per_degree, grid.samples_per_degree);
    const IndexWindow window = window_of(grid, grid, 90, 80);
    const Field flat = smoothed(
        grid, grid, [](auto, auto) { return 8848.86; }, window);
    for (const float h : flat.heights) REQUIRE(h == 8848.86F);
    const AxisPositions at = grid.positions();
    const auto plane = [&](auto i, auto j) {
      return 2 * (at.position(i) - static_cast<double>(window.x.first)) -
             0.5 * (at.position(j) - static_cast<double>(window.y.first));
    };
    const Field tilted = smoothed(grid, grid, plane, window);
    for (std::int64_t y = window.y.first; y <= window.y.last; ++y) {
      for (std::int64_t x = window.x.first; x <= window.x.last; ++x) {
        const double right =
            2 * static_cast<double>(x - window.x.first) - 0.5 * static_cast<double>(y - window.y.first);
        REQUIRE(static_cast<double>(tilted.at(x, y)) == Approx(right).margin(1e-3));
      }
    }
  }
  const Grid on_samples{{4096, 0}, 4096};
  const Relief rough = [](auto i, auto j) { return 9000 * noise(i, j, 5); };
  const IndexWindow window{{300, 400}, {500, 577}};
  const Field out = smoothed(on_samples, on_samples, rough, window);
  for (std::int64_t y = 500; y <= 577; ++y) {
    for (std::int64_t x = 300; x <= 400; ++x) REQUIRE(out.at(x, y) == static_cast<float>(rough(x, y)));
  }
}

TEST_CASE("of a smooth slope in whole metres, less noise of slope remains than the posts have") {
  const Grid grid{{3600, 0}, 4096};
  const double ratio = 4096.0 / 3600;
  const auto height = [](double i, double j) {  // of a place in post spacings
    return 500 + 60 * std::sin(0.021 * i + 0.013 * j) + 25 * std::cos(0.04 * j - 0.017 * i);
  };
  const IndexWindow window = window_of(grid, grid, 300, 300);
  const auto x0 = static_cast<double>(window.x.first) / ratio;
  const auto y0 = static_cast<double>(window.y.first) / ratio;
  const Field samples = smoothed(
      grid, grid,
      [&](auto i, auto j) {
        return std::round(height(static_cast<double>(i) - x0, static_cast<double>(j) - y0));
      },
      window);
  double of_samples = 0;
  double of_posts = 0;
  const auto rounded = [](double h, double step) { return std::round(h / step) * step; };
  for (int r = 1; r < 299; ++r) {
    for (int c = 1; c < 299; ++c) {
      const auto x = window.x.first + c;
      const auto y = window.y.first + r;
      const double baked = rounded(static_cast<double>(samples.at(x + 1, y)), 0.5) -
                           rounded(static_cast<double>(samples.at(x - 1, y)), 0.5);
      const double right = height((c + 1) / ratio, r / ratio) - height((c - 1) / ratio, r / ratio);
      of_samples += std::pow((baked - right) * ratio, 2);  // over two posts, as the next
      const double posts = std::round(height(c + 1, r)) - std::round(height(c - 1, r));
      of_posts += std::pow(posts - height(c + 1, r) + height(c - 1, r), 2);
    }
  }
  CHECK(of_samples < of_posts);
}

TEST_CASE("level water stays nearly level beside shores, the more the gentler they are") {
  for (const Grid& grid : {Grid{{1200, 0}, 2048}, Grid{{3600, 0}, 4096}}) {
    for (const double steepness : {0.4, 2.0, 6.0}) {
      const AxisPositions at = grid.positions();
      const IndexWindow window = window_of(grid, grid, 300, 300);
      const auto i0 = at.first_post_from(window.x.first);
      const auto j0 = at.first_post_from(window.y.first);
      const Relief shore = [&](auto i, auto j) {  // a winding coast
        const double inland =
            static_cast<double>(i - i0) - 80 - 15 * std::sin(0.13 * static_cast<double>(j - j0));
        return inland <= 0 ? 0 : std::ceil(steepness * inland + noise(i, j, 7));
      };
      const Field samples = smoothed(grid, grid, shore, window);
      double lowest = 0;
      double off = 0;
      for (std::int64_t y = window.y.first; y <= window.y.last; ++y) {
        for (std::int64_t x = window.x.first; x <= window.x.last; ++x) {
          const auto h = static_cast<double>(samples.at(x, y));
          lowest = std::min(lowest, h);
          const auto i = at.first_post_from(x);
          const auto j = at.first_post_from(y);
          const bool water =
              shore(i - 1, j - 1) == 0 && shore(i, j - 1) == 0 && shore(i - 1, j) == 0 && shore(i, j) == 0;
          if (water) off = std::max(off, std::abs(h));
        }
      }
      CAPTURE(grid.axis.posts_per_degree, steepness, lowest, off);
      CHECK(lowest > -0.5 - 0.25 * steepness);
      CHECK(off < 0.5 + 0.25 * steepness);
    }
  }
}

}  // namespace cairn
