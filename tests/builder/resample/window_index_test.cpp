#include "builder/resample/window_index.h"

#include <random>
#include <vector>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

bool overlap(const IndexWindow& a, const IndexWindow& b) {
  return a.x.first <= b.x.last && b.x.first <= a.x.last && a.y.first <= b.y.last && b.y.first <= a.y.last;
}

IndexWindow random_window(std::mt19937& random, std::int64_t span, std::int64_t side) {
  std::uniform_int_distribution<std::int64_t> corner(-span, span), length(0, side);
  const std::int64_t x = corner(random), y = corner(random);
  return {{x, x + length(random)}, {y, y + length(random)}};
}

}  // namespace

TEST_CASE("an index of windows finds those that a search through all finds") {
  std::mt19937 random(3);
  constexpr std::int64_t around = 900;
  for (const std::int64_t side : {0, 20, 700}) {
    std::vector<IndexWindow> extents;
    for (int i = 0; i < 300; ++i) extents.push_back(random_window(random, 1000, side));
    const WindowIndex index(extents);
    for (int i = 0; i < 200; ++i) {
      const IndexWindow window = random_window(random, 1500, 300);
      std::vector<std::size_t> expected;
      std::vector<WindowIndex::Turned> turned;
      for (std::size_t e = 0; e < extents.size(); ++e) {
        if (overlap(extents[e], window)) expected.push_back(e);
        for (const std::int64_t turn : {-around, std::int64_t{0}, around}) {
          const IndexRange x{extents[e].x.first + turn, extents[e].x.last + turn};
          if (overlap({x, extents[e].y}, window)) turned.push_back({e, turn});
        }
      }
      CHECK(index.overlapping(window) == expected);
      CHECK(index.overlapping(window, around) == turned);
    }
  }
  CHECK(WindowIndex({}).overlapping({{0, 5}, {0, 5}}).empty());
}

}  // namespace cairn
