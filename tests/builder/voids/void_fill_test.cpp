#include "builder/voids/void_fill.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

#include "builder/raster/raster_source.h"
#include "tests/support/test_data.h"

namespace cairn {
namespace {

constexpr float kVoid = std::numeric_limits<float>::quiet_NaN();

struct Raster {
  IndexWindow window;
  std::vector<float> heights;

  float at(std::int64_t x, std::int64_t y) const { return heights[window.offset(x, y)]; }
};

Raster raster(IndexWindow window, const std::function<float(std::int64_t, std::int64_t)>& height) {
  Raster made{window, {}};
  for (std::int64_t y = window.y.first; y <= window.y.last; ++y) {
    for (std::int64_t x = window.x.first; x <= window.x.last; ++x) made.heights.push_back(height(x, y));
  }
  return made;
}

// Void outside, as the caller of fill_voids() has it.
Raster part_of(const Raster& whole, IndexWindow window) {
  return raster(window, [&whole](std::int64_t x, std::int64_t y) {
    return whole.window.x.holds(x) && whole.window.y.holds(y) ? whole.at(x, y) : kVoid;
  });
}

FillPyramid pyramid_of(const Raster& whole) {
  FillPyramidBuilder builder(whole.window);
  builder.add(whole.window, whole.heights);
  return builder.complete();
}

Raster filled(const Raster& whole, const FillPyramid& pyramid, IndexWindow window) {
  Raster out{window, std::vector<float>(static_cast<std::size_t>(window.count()))};
  fill_voids(pyramid, part_of(whole, posts_to_fill(window)).heights, window, out.heights);
  return out;
}

float hills(std::int64_t x, std::int64_t y) {
  const auto u = static_cast<float>(x);
  const auto v = static_cast<float>(y);
  return 1500 + 400 * std::sin(u / 37) * std::cos(v / 53) + 90 * std::sin((u + 2 * v) / 11);
}

// Hills with a large disc, a strip, a thousand single posts and everything right of a slanting line void.
Raster holed_hills(IndexWindow window) {
  std::mt19937 random(1);
  return raster(window, [&](std::int64_t x, std::int64_t y) {
    const auto u = x - window.x.first;
    const auto v = y - window.y.first;
    const bool disc = (u - 130) * (u - 130) + (v - 120) * (v - 120) < 70 * 70;
    const bool hole = disc || (v > 250 && v < 258) || u > 330 + v / 5 || random() % 200 == 0;
    return hole ? kVoid : hills(x, y);
  });
}

constexpr IndexWindow kWindow{{223301, 223301 + 449}, {151207, 151207 + 379}};

}  // namespace

TEST_CASE("a filled window is the same bits whatever window it is computed in") {
  const Raster whole = holed_hills(kWindow);
  const FillPyramid pyramid = pyramid_of(whole);
  const IndexWindow wide{{kWindow.x.first - 20, kWindow.x.last + 30},
                         {kWindow.y.first - 11, kWindow.y.last + 9}};
  const Raster once = filled(whole, pyramid, wide);
  std::mt19937 random(3);
  const auto pick = [&random](IndexRange range) {
    const auto a = std::uniform_int_distribution<std::int64_t>(range.first, range.last)(random);
    return IndexRange{a,
                      std::uniform_int_distribution<std::int64_t>(a, std::min(a + 120, range.last))(random)};
  };
  for (int i = 0; i < 40; ++i) {
    const IndexWindow window{pick(wide.x), pick(wide.y)};
    REQUIRE(filled(whole, pyramid, window).heights == part_of(once, window).heights);
  }
}

TEST_CASE("the pyramid is the same bits whatever the blocks that it is made from") {
  const Raster whole = holed_hills(kWindow);
  const Raster once = filled(whole, pyramid_of(whole), kWindow);
  FillPyramidBuilder builder(kWindow);
  for (std::int64_t y = kWindow.y.last; y >= kWindow.y.first; y -= 47) {
    for (std::int64_t x = kWindow.x.first; x <= kWindow.x.last; x += 61) {
      const IndexWindow block{{x, std::min(x + 60, kWindow.x.last)}, {std::max(y - 46, kWindow.y.first), y}};
      builder.add(block, part_of(whole, block).heights);
    }
  }
  CHECK(builder.valid_posts() ==
        std::count_if(whole.heights.begin(), whole.heights.end(), [](float h) { return !std::isnan(h); }));
  CHECK(filled(whole, builder.complete(), kWindow).heights == once.heights);
}

TEST_CASE("every void is filled within the range of the valid posts, which stay as they are") {
  const Raster whole = holed_hills(kWindow);
  float least = 1e9f;
  float most = -1e9f;
  for (float h : whole.heights) {
    if (std::isnan(h)) continue;
    least = std::min(least, h);
    most = std::max(most, h);
  }
  const Raster out = filled(whole, pyramid_of(whole), kWindow);
  for (std::size_t i = 0; i < out.heights.size(); ++i) {
    REQUIRE(out.heights[i] >= least);
    REQUIRE(out.heights[i] <= most);
    if (!std::isnan(whole.heights[i])) REQUIRE(out.heights[i] == whole.heights[i]);
  }
}

TEST_CASE("a fill meets its rim without a cliff and has no steps inside") {
  const Raster whole = holed_hills(kWindow);
  const Raster out = filled(whole, pyramid_of(whole), kWindow);
  float steepest = 0;  // between valid neighbours
  float at_rim = 0;
  float inside = 0;
  for (std::int64_t y = kWindow.y.first; y <= kWindow.y.last; ++y) {
    for (std::int64_t x = kWindow.x.first; x < kWindow.x.last; ++x) {
      const int voids = std::isnan(whole.at(x, y)) + std::isnan(whole.at(x + 1, y));
      float& worst = voids == 0 ? steepest : voids == 1 ? at_rim : inside;
      worst = std::max(worst, std::abs(out.at(x + 1, y) - out.at(x, y)));
    }
  }
  CAPTURE(steepest, at_rim, inside);
  CHECK(at_rim < 2 * steepest);
  CHECK(inside < 2 * steepest);
}

TEST_CASE("one valid post fills a whole raster, and none leaves it void") {
  const auto lone = [](std::int64_t x, std::int64_t y) {
    return x == kWindow.x.first + 300 && y == kWindow.y.first + 2 ? 812.5f : kVoid;
  };
  const Raster one = raster(kWindow, lone);
  const IndexWindow window{{kWindow.x.first - 50, kWindow.x.first + 40},
                           {kWindow.y.last - 30, kWindow.y.last + 60}};
  for (float h : filled(one, pyramid_of(one), window).heights) REQUIRE(h == 812.5f);
  const Raster none = raster(kWindow, [](std::int64_t, std::int64_t) { return kVoid; });
  CHECK(pyramid_of(none).empty());
  for (float h : filled(none, pyramid_of(none), window).heights) REQUIRE(std::isnan(h));
}

TEST_CASE("a slope is carried across a void") {
  const auto slope = [](std::int64_t x, std::int64_t) {
    return static_cast<float>(x - kWindow.x.first) * 10;
  };
  const IndexRange hole{kWindow.x.first + 200, kWindow.x.first + 260};
  const Raster whole =
      raster(kWindow, [&](std::int64_t x, std::int64_t y) { return hole.holds(x) ? kVoid : slope(x, y); });
  const Raster out = filled(whole, pyramid_of(whole), kWindow);
  for (std::int64_t x = kWindow.x.first; x <= kWindow.x.last; ++x) {
    const std::int64_t y = kWindow.y.first + 190;
    REQUIRE(std::abs(out.at(x, y) - slope(x, y)) < 40);  // of 600 m across the void
    if (x < kWindow.x.last) REQUIRE(out.at(x + 1, y) >= out.at(x, y));
  }
}

TEST_CASE("voids on both sides of index 0, west and east of 180 W, are filled") {
  const auto constant = [](std::int64_t x, std::int64_t y) {
    return x > -60 && x < 90 && y > -35 ? kVoid : 321.0f;
  };
  const IndexWindow window{{-77, 120}, {-40, 90}};
  const Raster whole = raster(window, constant);
  for (float h : filled(whole, pyramid_of(whole), window).heights) REQUIRE(h == 321.0f);
}

TEST_CASE("filling depends on 140 to 176 posts around the window") {
  for (std::int64_t first : {0, 1, 17, 31, 222}) {
    for (std::int64_t count : {1, 2, 305, 512}) {
      const IndexWindow window{{first, first + count - 1}, {first, first + count - 1}};
      const IndexWindow posts = posts_to_fill(window);
      for (std::int64_t margin : {window.x.first - posts.x.first, posts.x.last - window.x.last}) {
        CHECK(margin >= 140);
        CHECK(margin <= 176);
      }
    }
  }
}

TEST_CASE("the voids of a real cell in high relief are filled, tile by tile as at once", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const auto source = open_raster(*data / "geotiff/N46E008.tif", {});
  REQUIRE(source.ok());
  const RasterInfo& info = (*source)->info();
  Raster cell{{{0, info.columns - 1}, {0, info.rows - 1}}, {}};
  cell.heights.resize(static_cast<std::size_t>(cell.window.count()));
  REQUIRE((*source)->read_heights({0, 0, info.columns, info.rows}, cell.heights).ok());
  CHECK(std::count_if(cell.heights.begin(), cell.heights.end(), [](float h) { return std::isnan(h); }) ==
        103743);

  const FillPyramid pyramid = pyramid_of(cell);
  const Raster once = filled(cell, pyramid, cell.window);
  for (std::size_t i = 0; i < once.heights.size(); ++i) {
    REQUIRE(once.heights[i] >= 187);  // the cell's lowest and highest posts
    REQUIRE(once.heights[i] <= 4173);
    if (!std::isnan(cell.heights[i])) REQUIRE(once.heights[i] == cell.heights[i]);
  }
  for (std::int64_t y = 0; y < info.rows; y += 409) {
    for (std::int64_t x = 0; x < info.columns; x += 303) {
      const IndexWindow tile{{x, std::min(x + 302, info.columns - 1)}, {y, std::min(y + 408, info.rows - 1)}};
      REQUIRE(filled(cell, pyramid, tile).heights == part_of(once, tile).heights);
    }
  }
}

}  // namespace cairn
