// SubtriangleErrorRanges against every sample of every triangle of a tile's hierarchy, one by one, from
// barycentric coordinates.

#include "runtime/lod/mesh/subtriangle_error_ranges.h"

#include <cmath>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

constexpr double kQuantum_m = 0.25;

using Triangle = SubtriangleErrorRanges::Triangle;

HeightTile random_tile(int size, std::int32_t relief, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<std::int32_t> quanta(-relief, relief);
  HeightTile tile;
  tile.size = size;
  for (int i = 0; i < size * size; ++i) tile.samples.push_back(quanta(random));
  return tile;
}

/// All of the hierarchy that have ranges, by halving.
std::vector<Triangle> triangles(const TileId& id, int size) {
  const int n = size - 1;
  const std::array<SubtriangleErrorRanges::Corner, 4> c{{{0, 0}, {n, 0}, {n, n}, {0, n}}};
  const std::size_t first = ((id.x ^ id.y) & 1) == 0 ? 1 : 0;
  std::vector<Triangle> all;
  for (const std::size_t right : {first, first + 2})
    all.push_back({c[(right + 1) % 4], c[(right + 3) % 4], c[right]});
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto [a, b, right] = all[i];
    const SubtriangleErrorRanges::Corner m{(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
    for (const Triangle& half : {Triangle{right, a, m}, Triangle{b, right, m}}) {
      const int span = std::max(std::abs(half[0][0] - half[1][0]), std::abs(half[0][1] - half[1][1]));
      if (span >= SubtriangleErrorRanges::kLeastSpan) all.push_back(half);
    }
  }
  return all;
}

/// The least and the most of triangle less surface at places of `steps` a cell, by part.
std::array<std::array<double, 2>, SubtriangleErrorRanges::kParts> measured(const HeightTile& tile,
                                                                           const Triangle& t, int steps) {
  const auto height_m = [&](int column, int row) { return tile.at(column, row) * kQuantum_m; };
  const auto& [a, b, c] = t;
  const double px = a[0] - c[0], py = a[1] - c[1], qx = b[0] - c[0], qy = b[1] - c[1];
  const double area = px * qy - py * qx;
  std::array<std::array<double, 2>, SubtriangleErrorRanges::kParts> ranges;
  ranges.fill({HUGE_VAL, -HUGE_VAL});
  for (int y = 0; y <= (tile.size - 1) * steps; ++y) {
    for (int x = 0; x <= (tile.size - 1) * steps; ++x) {
      const double column = static_cast<double>(x) / steps, row = static_cast<double>(y) / steps;
      const double u = ((column - c[0]) * qy - (row - c[1]) * qx) / area,
                   v = (px * (row - c[1]) - py * (column - c[0])) / area;
      if (u < 0 || v < 0 || u + v > 1) continue;
      const int w = std::min(static_cast<int>(column), tile.size - 2),
                s = std::min(static_cast<int>(row), tile.size - 2);
      const double e = column - w, n = row - s;
      const double surface = (1 - n) * ((1 - e) * height_m(w, s) + e * height_m(w + 1, s)) +
                             n * ((1 - e) * height_m(w, s + 1) + e * height_m(w + 1, s + 1));
      const double above =
          u * height_m(a[0], a[1]) + v * height_m(b[0], b[1]) + (1 - u - v) * height_m(c[0], c[1]) - surface;
      std::size_t part = 0;
      for (int j = 0; j < SubtriangleErrorRanges::kSteps; ++j) {
        for (int i = 0; i + j < SubtriangleErrorRanges::kSteps; ++i, ++part) {
          if (u * 4 < i || u * 4 > i + 1 || v * 4 < j || v * 4 > j + 1) continue;
          ranges[part][0] = std::min(ranges[part][0], above);
          ranges[part][1] = std::max(ranges[part][1], above);
        }
      }
    }
  }
  return ranges;
}

TEST_CASE("SubtriangleErrorRanges are those of the samples, at most one unit too wide") {
  for (const TileId& id : {TileId{3, 4, 6}, TileId{3, 5, 6}}) {
    for (const std::int32_t relief : {0, 3, 40000}) {
      const HeightTile tile = random_tile(65, relief, 3);
      const SubtriangleErrorRanges ranges(tile, id, kQuantum_m, false);
      int compared = 0;
      for (const Triangle& t : triangles(id, tile.size)) {
        const SubtriangleErrorRanges::Ranges& r = ranges.of(t);
        const double unit = static_cast<double>(r.unit_m);
        const auto expected = measured(tile, t, 1);
        CAPTURE(id.x, relief, t[0], t[1], t[2], unit);
        for (std::size_t part = 0; part < SubtriangleErrorRanges::kParts; ++part, ++compared) {
          CHECK(std::abs(r.least[part] * unit - expected[part][0] + unit / 2) <= unit * 0.51 + 1e-9);
          CHECK(std::abs(r.most[part] * unit - expected[part][1] - unit / 2) <= unit * 0.51 + 1e-9);
          CHECK(std::max(-r.least[part], int{r.most[part]}) * unit <= r.largest_m());
        }
        for (std::size_t i = 0; i < 3; ++i) CHECK(r.quanta[i] == tile.at(t[i][0], t[i][1]));
      }
      CHECK(compared > 500);
    }
  }
}

TEST_CASE("SubtriangleErrorRanges hold between samples where places between samples count") {
  const TileId id{3, 4, 6};
  const HeightTile tile = random_tile(33, 400, 8);
  const SubtriangleErrorRanges ranges(tile, id, kQuantum_m, true);
  for (const Triangle& t : triangles(id, tile.size)) {
    const SubtriangleErrorRanges::Ranges& r = ranges.of(t);
    const auto expected = measured(tile, t, 8);
    CAPTURE(t[0], t[1], t[2]);
    for (std::size_t part = 0; part < SubtriangleErrorRanges::kParts; ++part) {
      CHECK(r.least[part] * static_cast<double>(r.unit_m) <= expected[part][0] + 1e-9);
      CHECK(r.most[part] * static_cast<double>(r.unit_m) >= expected[part][1] - 1e-9);
    }
  }
}

}  // namespace
}  // namespace cairn::test
