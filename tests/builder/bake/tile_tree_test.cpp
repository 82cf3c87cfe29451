// The tree of a bake's tiles over made-up areas, against what every tile of the area says by itself.

#include "builder/bake/tile_tree.h"

#include <map>
#include <random>
#include <set>
#include <vector>

#include <catch2/catch.hpp>

#include "cairn/geo.h"

namespace cairn {
namespace {

struct Area {
  GeoBounds bounds;
  int level = 0;
};

bool overlap(const GeoBounds& a, const GeoBounds& b) {
  return a.west < b.east && b.west < a.east && a.south < b.north && b.south < a.north;
}

// A tile needs the finest level of all areas that it overlaps.
TileTree::LeafLevel leaf_level_of(const std::vector<Area>& areas) {
  return [areas](const TileId& id) -> std::optional<int> {
    std::optional<int> finest;
    for (const Area& area : areas) {
      if (overlap(tile_bounds(id), area.bounds)) finest = std::max(finest.value_or(kMinLevel), area.level);
    }
    return finest;
  };
}

std::vector<Area> random_areas(std::mt19937& random) {
  std::uniform_real_distribution<double> place(0, 4), side(0.1, 2);
  std::uniform_int_distribution<int> level(-2, 3);
  std::vector<Area> areas(3);
  for (Area& area : areas) {
    area.bounds.west = place(random);
    area.bounds.south = place(random);
    area.bounds.east = area.bounds.west + side(random);
    area.bounds.north = area.bounds.south + side(random);
    area.level = level(random);
  }
  return areas;
}

// Every tile from the coarsest level down, until one needs no finer tiles.
void collect_leaves(const TileTree::LeafLevel& leaf_level, int top, const TileId& id,
                    std::set<TileId>& leaves) {
  const auto level = is_valid(id) ? leaf_level(id) : std::nullopt;
  if (!level) return;
  if (id.level >= top && *level <= id.level) {
    leaves.insert(id);
    return;
  }
  for (int q = 0; q < 4; ++q) collect_leaves(leaf_level, top, child_of(id, q), leaves);
}

}  // namespace

TEST_CASE("the units of a tree hold each leaf once, at most sixteen each, and no tile that is not there") {
  std::mt19937 random(1);
  for (int trial = 0; trial < 40; ++trial) {
    const auto leaf_level = leaf_level_of(random_areas(random));
    for (const int top : {kMinLevel, -1, 0}) {
      const TileTree tree(top, leaf_level);
      std::set<TileId> expected;
      collect_leaves(leaf_level, top, {kMinLevel, 0, 0}, expected);
      std::vector<TileId> found;
      for (const TileId& unit : tree.units()) {
        const auto leaves = tree.leaves(unit);
        CHECK(!leaves.empty());
        CHECK(leaves.size() <= 16);
        for (const TileId& leaf : leaves) {
          CHECK(tree.is_leaf(leaf));
          CHECK(ancestor_of(leaf, unit.level) == unit);
        }
        found.insert(found.end(), leaves.begin(), leaves.end());
      }
      CHECK(std::set<TileId>(found.begin(), found.end()) == expected);
      CHECK(found.size() == expected.size());
      CHECK(tree.leaf_count() == expected.size());
    }
  }
}

TEST_CASE("the tiles by level are the leaves and their ancestors up to the top") {
  std::mt19937 random(2);
  for (int trial = 0; trial < 40; ++trial) {
    const auto leaf_level = leaf_level_of(random_areas(random));
    const int top = -1;
    const TileTree tree(top, leaf_level);
    std::set<TileId> all;
    std::map<TileId, int> children;
    for (const TileId& unit : tree.units()) {
      for (TileId id : tree.leaves(unit)) {
        while (all.insert(id).second && id.level > top) {
          ++children[parent_of(id)];
          id = parent_of(id);
        }
      }
    }
    std::map<int, std::uint64_t> expected;
    for (const TileId& id : all) ++expected[id.level];
    CHECK(tree.tiles_by_level() == expected);
    for (const auto& [id, count] : children) CHECK(tree.children_of(id) == count);
  }
}

TEST_CASE("a tile that only touches the layer lends its edge and is as fine as its finest neighbour") {
  const auto leaf_level = leaf_level_of({{{0, 0, 1, 1}, 2}});
  // The cell N00E000 is a quadrant of the top's tile, whose other three have nothing inside.
  const TileTree tree(-1, leaf_level, [](const TileId& id) {
    const GeoBounds b = tile_bounds(id);
    return b.west <= 1 && b.east >= 0 && b.south <= 1 && b.north >= 0;
  });
  const TileId inside{2, 180 * 4 + 3, 90 * 4}, beyond = neighbour_of(inside, 1, 0);
  CHECK(tree.wants(inside));
  CHECK_FALSE(tree.edge_only(inside));
  CHECK_FALSE(tree.wants(beyond));
  CHECK(tree.edge_only(beyond));
  CHECK_FALSE(tree.edge_only(neighbour_of(beyond, 1, 0)));
  std::set<TileId> leaves;
  for (const TileId& unit : tree.units()) {
    for (const TileId& leaf : tree.leaves(unit)) leaves.insert(leaf);
  }
  CHECK(leaves.contains(beyond));
  CHECK(leaves.size() == 25);  // four by four, and those beside them in the east, the north and the corner
}

}  // namespace cairn
