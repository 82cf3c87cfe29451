// The triangulations of the rqt layer, against oracles that know the papers' words only: Algorithm 2 as it
// stands, and triangles put together by Algorithm 1.

#include <array>
#include <cmath>
#include <map>
#include <random>
#include <set>

#include <catch2/catch.hpp>

#include "format/rqt_block.h"
#include "format/rqt_borders.h"
#include "format/rqt_triangulate.h"

namespace cairn {
namespace {

using Place = std::array<int, 2>;
using Corners = std::array<Place, 3>;  // the ends of the hypotenuse, then the right angle

Place middle(const Place& a, const Place& b) {
  return {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
}
bool can_be_bisected(const Corners& t) {
  return (t[0][0] + t[1][0]) % 2 == 0 && (t[0][1] + t[1][1]) % 2 == 0;
}
std::array<Corners, 2> halves(const Corners& t) {
  const Place base = middle(t[0], t[1]);
  return {Corners{t[2], t[0], base}, Corners{t[1], t[2], base}};
}
std::array<Corners, 2> roots(int size, bool rising) {
  const int n = size - 1;
  if (rising) return {Corners{Place{0, 0}, {n, n}, {n, 0}}, Corners{Place{n, n}, {0, 0}, {0, n}}};
  return {Corners{Place{0, n}, {n, 0}, {0, 0}}, Corners{Place{n, 0}, {0, n}, {n, n}}};
}

// Intel 2012, Algorithm 1.
void collect(const RqtSteps& steps, int k, const Corners& t, std::vector<Corners>& out) {
  const Place base = middle(t[0], t[1]);
  if (!can_be_bisected(t) || !steps.has(base[0], base[1], k)) {
    out.push_back(t);
    return;
  }
  for (const Corners& half : halves(t)) collect(steps, k, half, out);
}
std::vector<Corners> triangles_of(const RqtSteps& steps, int k) {
  std::vector<Corners> out;
  for (const Corners& root : roots(steps.size(), steps.rising())) collect(steps, k, root, out);
  return out;
}

int doubled_area(const Place& a, const Place& b, const Place& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
}

// The largest distance of the samples inside a triangle and on its edges from its plane.
double error_of(const HeightTile& tile, const Corners& t) {
  double worst = 0;
  const double area = doubled_area(t[0], t[1], t[2]);
  const auto [west, east] = std::minmax({t[0][0], t[1][0], t[2][0]});
  const auto [south, north] = std::minmax({t[0][1], t[1][1], t[2][1]});
  for (int row = south; row <= north; ++row) {
    for (int column = west; column <= east; ++column) {
      const Place p{column, row};
      const std::array<double, 3> w{doubled_area(t[1], t[2], p) / area, doubled_area(t[2], t[0], p) / area,
                                    doubled_area(t[0], t[1], p) / area};
      if (w[0] < 0 || w[1] < 0 || w[2] < 0) continue;
      double plane = 0;
      for (std::size_t i = 0; i < 3; ++i) plane += w[i] * tile.at(t[i][0], t[i][1]);
      worst = std::max(worst, std::abs(plane - tile.at(column, row)));
    }
  }
  return worst;
}

// Intel 2012, Algorithm 2, by definition: all triangles of the hierarchy by their base, the finest first; a
// vertex is enabled where one of the triangles below it was bisected or a triangle that it is the base of is
// off.
class Definition {
 public:
  Definition(const HeightTile& tile, bool rising, double tolerance) : tile_(tile), tolerance_(tolerance) {
    for (const Corners& root : roots(tile.size, rising)) add(root, 0);
  }
  std::set<Place> enabled() const {
    std::set<Place> on;
    for (auto level = levels_.rbegin(); level != levels_.rend(); ++level) {
      for (const auto& [base, triangles] : level->second) {
        for (const Corners& t : triangles) {
          bool needed = error_of(tile_, t) >= tolerance_;
          for (const Corners& half : halves(t))
            needed = needed || (can_be_bisected(half) && on.contains(middle(half[0], half[1])));
          if (needed) on.insert(base);
        }
      }
    }
    return on;
  }

 private:
  void add(const Corners& t, int depth) {
    if (!can_be_bisected(t)) return;
    levels_[depth][middle(t[0], t[1])].push_back(t);
    for (const Corners& half : halves(t)) add(half, depth + 1);
  }
  const HeightTile& tile_;
  double tolerance_;
  std::map<int, std::map<Place, std::vector<Corners>>> levels_;
};

// Rough here, smooth there, with a cliff and a plain.
HeightTile terrain(int size, unsigned seed) {
  std::mt19937 random(seed);
  HeightTile tile{size, std::vector<std::int32_t>(static_cast<std::size_t>(size * size)), {}};
  const double phase = static_cast<double>(random() % 100);
  for (int row = 0; row < size; ++row) {
    for (int column = 0; column < size; ++column) {
      const double x = column * 8.0 / size, y = row * 8.0 / size;
      double h = 300 * std::sin(x + phase) * std::cos(1.7 * y) + 4000;
      h += x > 4 ? static_cast<double>(random() % 60) * (x - 4) : 0;
      if (x + y > 11) h = 4100;
      if (row > size / 2 && column * 3 > size && column * 3 < size + 9) h += 900;
      tile.samples[static_cast<std::size_t>(row * size + column)] = static_cast<std::int32_t>(h);
    }
  }
  return tile;
}

RqtBlock block_of(int size, unsigned seed, int steps = 5, float tolerance_m = 4) {
  return {tolerance_m, steps, triangulate(terrain(size, seed), 0.25, tolerance_m, steps, seed % 2 == 0)};
}

bool is_closed(const RqtSteps& steps) {
  bool closed = true;
  for_each_rqt_vertex(steps.size(), steps.rising(), [&](std::size_t i, const RqtNeeds& needs) {
    const auto all = steps.all();
    closed = closed && all[needs.first] >= all[i] && all[needs.second] >= all[i];
  });
  return closed;
}

}  // namespace

TEST_CASE("the triangulations are those of the paper's Algorithm 2, worked out by definition") {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    for (const int size : {5, 17, 33}) {
      const HeightTile tile = terrain(size, seed);
      const bool rising = seed % 2 == 0;
      const RqtSteps steps = triangulate(tile, 0.25, 3, 4, rising);
      for (int k = 0; k < 4; ++k) {
        const std::set<Place> expected = Definition(tile, rising, 12.0 * (1 << k)).enabled();
        std::size_t found = 0;
        for (const Place& p : expected) found += steps.has(p[0], p[1], k) ? 1 : 0;
        CHECK(found == expected.size());
        CHECK(triangles_of(steps, k).size() == steps.triangle_count(k));
        std::size_t all = 0;
        for (const std::uint8_t s : steps.all()) all += s > k ? 1 : 0;
        CHECK(all == expected.size() + 4);
      }
    }
  }
}

TEST_CASE("every triangulation is crack-free and within its tolerance of every sample") {
  const HeightTile tile = terrain(65, 7);
  const RqtSteps steps = triangulate(tile, 0.25, 4, 6, false);
  for (int k = 0; k < 6; ++k) {
    std::map<std::array<Place, 2>, int> edges;
    int area = 0;
    for (const Corners& t : triangles_of(steps, k)) {
      CHECK(error_of(tile, t) * 0.25 < 4.0 * (1 << k));
      area += doubled_area(t[0], t[1], t[2]) < 0 ? -doubled_area(t[0], t[1], t[2])
                                                 : doubled_area(t[0], t[1], t[2]);
      for (std::size_t i = 0; i < 3; ++i) {
        std::array<Place, 2> edge{t[i], t[(i + 1) % 3]};
        if (edge[1] < edge[0]) std::swap(edge[0], edge[1]);
        ++edges[edge];
      }
    }
    CHECK(area == 2 * 64 * 64);
    for (const auto& [edge, count] : edges) {
      const bool on_rim = (edge[0][0] == edge[1][0] && edge[0][0] % 64 == 0) ||
                          (edge[0][1] == edge[1][1] && edge[0][1] % 64 == 0);
      CHECK(count == (on_rim ? 1 : 2));
    }
  }
}

TEST_CASE("an rqt block gives back its triangulations, at one bit a visited vertex or less") {
  for (const int size : {257, 513}) {
    for (const float tolerance_m : {0.3f, 4.0f, 1e6f}) {
      const RqtBlock block = block_of(size, 5, 8, tolerance_m);
      const auto bytes = encode_rqt_block(block);
      CHECK(bytes.size() <= 12 + (rqt_bit_count(bytes) + 7) / 8);
      const auto back = decode_rqt_block(bytes, size, block.vertices.rising());
      REQUIRE(back.ok());
      CHECK(back->tolerance_m == block.tolerance_m);
      CHECK(back->steps == block.steps);
      CHECK(back->vertices == block.vertices);
    }
  }
}

TEST_CASE("an rqt block that is cut, with bytes left over, or of another tile size is refused") {
  const auto bytes = encode_rqt_block(block_of(257, 3));
  for (std::size_t length = 0; length < bytes.size(); ++length)
    REQUIRE_FALSE(decode_rqt_block(std::span(bytes).first(length), 257, false).ok());
  auto longer = bytes;
  longer.push_back(std::byte{0});
  CHECK_FALSE(decode_rqt_block(longer, 257, false).ok());
  CHECK_FALSE(decode_rqt_block(bytes, 513, false).ok());
}

TEST_CASE("an rqt block with any bit flipped is refused or gives triangulations without cracks", "[slow]") {
  for (const int size : {17, 257}) {
    const auto bytes = encode_rqt_block(block_of(size, 4));
    std::size_t refused = 0;
    for (std::size_t bit = 0; bit < bytes.size() * 8; bit += size == 17 ? 1 : 5) {
      auto flipped = bytes;
      flipped[bit / 8] ^= std::byte{1} << (bit % 8);
      const auto back = decode_rqt_block(flipped, size, true);
      refused += back.ok() ? 0 : 1;
      if (back) REQUIRE(is_closed(back->vertices));
    }
    CHECK(refused > 12);
  }
}

TEST_CASE("neighbours agree on their edges, with no vertex more than that takes") {
  constexpr int kSize = 17, kTiles = 4, kWide = (kSize - 1) * kTiles + 1;
  for (const unsigned seed : {1u, 2u, 3u}) {
    std::map<TileId, RqtSteps> tiles;
    RqtBorders borders(kSize);
    for (int i = 0; i < kTiles * kTiles; ++i) {
      const TileId id{4, 100 + i % kTiles, 96 + i / kTiles};
      tiles.emplace(id, triangulate(terrain(kSize, seed * 100 + static_cast<unsigned>(i)), 0.25,
                                    i % 3 == 0 ? 1.0f : 40.0f, 3, root_rises(id)));
      borders.add(id, tiles.at(id));
    }
    borders.settle();
    // The same on one large square: the tiles' hierarchies are its own.
    RqtSteps whole(kWide, root_rises({2, 25, 24}));
    for (const auto& [id, own] : tiles) {
      for (int row = 0; row < kSize; ++row) {
        for (int column = 0; column < kSize; ++column) {
          const bool corner = column % (kSize - 1) == 0 && row % (kSize - 1) == 0;
          whole.raise((id.x - 100) * (kSize - 1) + column, (id.y - 96) * (kSize - 1) + row,
                      corner ? kMostRqtSteps : own.at(column, row));
        }
      }
    }
    for (auto& [id, own] : tiles) {
      borders.apply(id, own);
      CHECK(is_closed(own));
      for (int row = 0; row < kSize; ++row) {
        for (int column = 0; column < kSize; ++column)
          REQUIRE(own.at(column, row) ==
                  whole.at((id.x - 100) * (kSize - 1) + column, (id.y - 96) * (kSize - 1) + row));
      }
    }
  }
}

TEST_CASE("neighbours agree across the antimeridian") {
  RqtBorders borders(17);
  RqtSteps west(17, true), east(17, true);
  west.raise(16, 3, 2);
  const TileId last{0, 359, 90}, first{0, 0, 90};
  borders.add(last, west);
  borders.add(first, east);
  borders.settle();
  borders.apply(first, east);
  CHECK(east.at(0, 3) == 2);
}

}  // namespace cairn
