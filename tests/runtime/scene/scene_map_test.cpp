#include "runtime/scene/scene_map.h"

#include <algorithm>
#include <map>
#include <random>
#include <set>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

constexpr int kFinest = 12;
constexpr std::array kQuadtrees{RefinementPattern::normal, RefinementPattern::plus, RefinementPattern::cross,
                                RefinementPattern::restricted, RefinementPattern::balanced};

/// Far from the poles and the antimeridian, on a corner of the tiles of every level that a test counts.
TileId mid_world(std::int32_t dx, std::int32_t dy) {
  return {kFinest, (180 << kFinest) + dx, (90 << kFinest) + dy};
}

SceneMap counted_map(const TileId& eye, int levels, RefinementPattern pattern) {
  return build_scene_map({eye, eye.level - levels + 1, pattern});
}

/// Counts over every eye tile of a 2^(K+2) square and every one-tile move along an axis from it.
struct Enumeration {
  std::set<std::size_t> totals;
  std::size_t largest_difference = 0;
  std::size_t smallest_difference = SIZE_MAX;
};

Enumeration enumerate(RefinementPattern pattern, int levels, std::span<const std::pair<int, int>> moves) {
  const std::int32_t side = 1 << (levels + 2);
  Enumeration found;
  for (std::int32_t y = 0; y < side; ++y) {
    for (std::int32_t x = 0; x < side; ++x) {
      const auto here = sources_of(counted_map(mid_world(x, y), levels, pattern));
      found.totals.insert(here.size());
      for (const auto& [dx, dy] : moves) {
        const auto there = sources_of(counted_map(mid_world(x + dx, y + dy), levels, pattern));
        found.largest_difference = std::max(found.largest_difference, difference(here, there).size());
        found.smallest_difference = std::min(found.smallest_difference, difference(here, there).size());
      }
    }
  }
  return found;
}

constexpr std::array<std::pair<int, int>, 4> kAxis{{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};
constexpr std::array<std::pair<int, int>, 4> kDiagonal{{{1, 1}, {-1, 1}, {1, -1}, {-1, -1}}};

/// The area as a rectangle on the grid of `level`, cut where the world ends.
struct Rect {
  std::int64_t west, south, east, north;
};

Rect rect_of(const TileId& id, int level) {
  const int down = level - id.level;
  const std::int64_t west = static_cast<std::int64_t>(id.x) << down;
  const std::int64_t south = static_cast<std::int64_t>(id.y) << down;
  return {west, south, std::min<std::int64_t>(west + (1LL << down), tiles_around(level)),
          std::min<std::int64_t>(south + (1LL << down), tiles_pole_to_pole(level))};
}

bool overlap(const Rect& a, const Rect& b) {
  return a.west < b.east && b.west < a.east && a.south < b.north && b.south < a.north;
}

/// Whether they share an edge or a corner, on either side of the antimeridian.
bool touch(const Rect& a, const Rect& b, std::int64_t around) {
  if (a.south > b.north || b.south > a.north) return false;
  for (const std::int64_t shift : {-around, std::int64_t{0}, around}) {
    if (a.west + shift <= b.east && b.west <= a.east + shift) return true;
  }
  return false;
}

/// Over pairs of tiles neither of which is coarser than `coarsest`.
int largest_step_between_touching(const SceneMap& map, int level, int coarsest = kMinLevel) {
  int step = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (map[j].area.level < coarsest) continue;  // j < i, so it is the coarser of the two
      if (touch(rect_of(map[i].area, level), rect_of(map[j].area, level), tiles_around(level))) {
        step = std::max(step, std::abs(map[i].area.level - map[j].area.level));
      }
    }
  }
  return step;
}

void require_exact_cover(const SceneMap& map, int level) {
  std::int64_t covered = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    const Rect a = rect_of(map[i].area, level);
    covered += (a.east - a.west) * (a.north - a.south);
    for (std::size_t j = 0; j < i; ++j) REQUIRE_FALSE(overlap(a, rect_of(map[j].area, level)));
  }
  REQUIRE(covered == static_cast<std::int64_t>(tiles_around(level)) * tiles_pole_to_pole(level));
}

bool has_area(const SceneMap& map, const TileId& area) {
  return std::any_of(map.begin(), map.end(), [&](const SceneTile& tile) { return tile.area == area; });
}

TileId random_eye(std::mt19937_64& random, int level) {
  std::uniform_int_distribution<std::int32_t> x(0, tiles_around(level) - 1);
  std::uniform_int_distribution<std::int32_t> y(0, tiles_pole_to_pole(level) - 1);
  std::uniform_int_distribution<int> border(0, 7);
  TileId eye{level, x(random), y(random)};
  const int where = border(random);
  if (where == 0) eye.x = tiles_around(level) - 1;
  if (where == 1) eye.x = 0;
  if (where == 2) eye.y = tiles_pole_to_pole(level) - 1;
  if (where == 3) eye.y = 0;
  return eye;
}

}  // namespace

TEST_CASE("the table of block counts comes out of exhaustive enumeration") {
  using Set = std::set<std::size_t>;
  const std::map<RefinementPattern, std::pair<Set, std::size_t>> table{
      {RefinementPattern::normal, {Set{13}, 13}},
      {RefinementPattern::plus, {Set{19, 22, 25, 28, 29, 31, 32, 35, 39}, 14}},
      {RefinementPattern::cross, {Set{22, 25, 28, 31, 32, 34, 38, 40, 44, 52}, 28}},
      {RefinementPattern::restricted, {Set{52}, 10}},
      {RefinementPattern::balanced, {Set{52, 60, 66, 72, 78, 84, 87, 93, 102}, 46}},
      {RefinementPattern::nine, {Set{9}, 3}},
      {RefinementPattern::window, {Set{64}, 8}}};
  for (const auto& [pattern, expected] : table) {
    const Enumeration found = enumerate(pattern, 4, kAxis);
    INFO(to_string(pattern));
    CHECK(found.totals == expected.first);
    CHECK(found.largest_difference == expected.second);
  }
}

TEST_CASE("the restricted map is 12(K-1)+16 tiles and a diagonal move at most doubles its 10") {
  for (int levels = 2; levels <= 4; ++levels) {
    const Enumeration axis = enumerate(RefinementPattern::restricted, levels, kAxis);
    CHECK(axis.totals == std::set<std::size_t>{static_cast<std::size_t>(12 * (levels - 1) + 16)});
    CHECK(axis.largest_difference == 10);
    CHECK(enumerate(RefinementPattern::restricted, levels, kDiagonal).largest_difference <= 20);
  }
}

TEST_CASE("a window loads n tiles a move along an axis and 2n-1 along a diagonal") {
  CHECK(enumerate(RefinementPattern::window, 2, kAxis).largest_difference == 8);
  CHECK(enumerate(RefinementPattern::window, 2, kDiagonal).largest_difference == 15);
  CHECK(enumerate(RefinementPattern::nine, 2, kDiagonal).largest_difference == 5);
}

TEST_CASE("the map of Melkisetoglu's figures 6.2, 8x8 tiles, has 10 blocks, or 28 with the cross") {
  const TileId middle = mid_world(4, 4);
  CHECK(counted_map(middle, 3, RefinementPattern::normal).size() == 10);
  CHECK(counted_map(middle, 3, RefinementPattern::cross).size() == 28);
}

TEST_CASE("every place of the Earth is covered once, whatever the eye, the level and the pattern") {
  std::mt19937_64 random(4);
  for (int i = 0; i < 400; ++i) {
    const int finest = static_cast<int>(random() % 20) + kMinLevel;
    const TileId eye = random_eye(random, finest);
    for (const RefinementPattern pattern : kQuadtrees) {
      INFO(to_string(eye) << " " << to_string(pattern));
      const SceneMap map = build_scene_map({eye, kMinLevel, pattern});
      REQUIRE(std::is_sorted(map.begin(), map.end()));
      require_exact_cover(map, finest);
    }
  }
}

TEST_CASE("all 8 neighbours of the eye's tile are of the finest level in cross, restricted and balanced") {
  std::mt19937_64 random(5);
  for (int i = 0; i < 2000; ++i) {
    const int finest = static_cast<int>(random() % 24) + kMinLevel + 1;
    const TileId eye = random_eye(random, finest);
    for (const RefinementPattern pattern :
         {RefinementPattern::cross, RefinementPattern::restricted, RefinementPattern::balanced}) {
      const SceneMap map = build_scene_map({eye, kMinLevel, pattern});
      for (int dy = -1; dy <= 1; ++dy) {
        for (int dx = -1; dx <= 1; ++dx) {
          const TileId neighbour = neighbour_of(eye, dx, dy);
          INFO(to_string(eye) << " " << to_string(pattern) << " " << dx << "," << dy);
          if (is_valid(neighbour)) REQUIRE(has_area(map, neighbour));
        }
      }
    }
  }
}

TEST_CASE("tiles that touch differ by at most two levels in restricted and by at most one in balanced") {
  std::mt19937_64 random(6);
  int largest_restricted = 0;
  for (int levels = 2; levels <= 9; ++levels) {
    for (int i = 0; i < 60; ++i) {
      const TileId eye = random_eye(random, levels - 1);
      largest_restricted =
          std::max(largest_restricted, largest_step_between_touching(build_scene_map({eye}), eye.level, -3));
      const SceneMap balanced = build_scene_map({eye, kMinLevel, RefinementPattern::balanced});
      INFO(to_string(eye));
      REQUIRE(largest_step_between_touching(balanced, eye.level) <= 1);
    }
  }
  CHECK(largest_restricted == 2);  // and not less: no map with 4x4 groups can promise one
}

TEST_CASE("the restricted map steps by one level only at 1 of 16 eye tiles, K = 4") {
  int ones = 0;
  for (std::int32_t y = 0; y < 16; ++y) {
    for (std::int32_t x = 0; x < 16; ++x) {
      const SceneMap map = counted_map(mid_world(x, y), 4, RefinementPattern::restricted);
      const int step = largest_step_between_touching(map, kFinest);
      REQUIRE(step <= 2);
      ones += step == 1;
    }
  }
  CHECK(ones == 16);
}

TEST_CASE(
    "a tile that cannot be had shows its nearest ancestor, and areas that show the same one are merged") {
  std::mt19937_64 random(8);
  for (int i = 0; i < 300; ++i) {
    const TileId eye = random_eye(random, static_cast<int>(random() % 12));
    const std::uint64_t salt = random();
    const HasTile has = [&](const TileId& id) {
      return id.level == kMinLevel || (std::hash<TileId>{}(id) ^ salt) * 0x9E3779B97F4A7C15u >> 62 != 0;
    };
    const SceneMap map = build_scene_map({eye}, has);
    require_exact_cover(map, eye.level);
    std::map<TileId, int> inheriting;
    for (const SceneTile& tile : map) {
      REQUIRE(tile.has_source());
      REQUIRE(has(tile.source()));
      for (int level = tile.area.level; level > tile.source_level; --level) {
        REQUIRE_FALSE(has(ancestor_of(tile.area, level)));
      }
      if (tile.source_level < tile.area.level) ++inheriting[parent_of(tile.area)];
    }
    for (const auto& [parent, count] : inheriting) REQUIRE(count < 4);
  }
}

TEST_CASE("where no ancestor can be had the map says so") {
  const SceneMap none = build_scene_map({tile_at({28.5, 36.5}, 3)}, [](const TileId&) { return false; });
  REQUIRE(none.size() == 1);
  CHECK_FALSE(none[0].has_source());
  CHECK(sources_of(none).empty());
}

TEST_CASE("patterns are read back from their words") {
  for (const RefinementPattern pattern : all_refinement_patterns())
    CHECK(refinement_pattern_from(to_string(pattern)) == pattern);
  CHECK_FALSE(refinement_pattern_from("x").has_value());
}

}  // namespace cairn
