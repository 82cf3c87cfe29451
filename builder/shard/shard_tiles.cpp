#include "builder/shard/shard_tiles.h"

#include <algorithm>
#include <cstdint>

#include "format/tile_number.h"

namespace cairn {
namespace {

struct Unit {
  TileId id;
  std::uint64_t place = 0;  // of its south-western corner on the Z curve
  std::uint64_t leaves = 0;
};

std::uint64_t place_of(const TileId& id) {
  const int finer = kMaxLevel - id.level;
  const auto x = static_cast<std::uint64_t>(id.x) << finer, y = static_cast<std::uint64_t>(id.y) << finer;
  return z_curve(x, y);
}

std::vector<Unit> units_with_leaves(const TileTree* tree) {
  std::vector<Unit> units;
  if (tree == nullptr) return units;
  for (const TileId& id : tree->units()) units.push_back({id, place_of(id), tree->leaves(id).size()});
  return units;
}

bool is_within(const TileId& id, const TileId& subtree) {
  return id.level >= subtree.level && ancestor_of(id, subtree.level) == subtree;
}

// Units `first` to `last` - 1 as subtrees to which no unit before or after belongs.
ShardTiles as_subtrees(const std::vector<Unit>& units, std::size_t first, std::size_t last, int top) {
  const auto is_shared = [&](const TileId& subtree) {
    return (first > 0 && is_within(units[first - 1].id, subtree)) ||
           (last < units.size() && is_within(units[last].id, subtree));
  };
  ShardTiles tiles;
  for (std::size_t u = first; u < last; ++u) {
    tiles.leaves += units[u].leaves;
    if (!tiles.subtrees.empty() && is_within(units[u].id, tiles.subtrees.back())) continue;
    TileId subtree = units[u].id;
    while (subtree.level > top && !is_shared(parent_of(subtree))) subtree = parent_of(subtree);
    tiles.subtrees.push_back(subtree);
  }
  return tiles;
}

std::vector<ShardTiles> cut(const std::vector<Unit>& units, int top,
                            const std::vector<std::uint64_t>& first_places) {
  std::vector<ShardTiles> shards;
  std::size_t first = 0;
  for (std::size_t s = 0; s < first_places.size(); ++s) {
    std::size_t last = units.size();
    if (s + 1 < first_places.size()) {
      last = static_cast<std::size_t>(
          std::lower_bound(units.begin(), units.end(), first_places[s + 1],
                           [](const Unit& unit, std::uint64_t place) { return unit.place < place; }) -
          units.begin());
    }
    shards.push_back(as_subtrees(units, first, last, top));
    first = last;
  }
  return shards;
}

// Where each shard begins on the curve: after an equal share of the leaves of both layers, each of whose
// units are in the order of the curve.
std::vector<std::uint64_t> places_between(const std::vector<Unit>& heights, const std::vector<Unit>& images,
                                          std::size_t shards) {
  std::uint64_t all = 0;
  for (const std::vector<Unit>* units : {&heights, &images})
    for (const Unit& unit : *units) all += unit.leaves;
  std::vector<std::uint64_t> first_places(shards, UINT64_MAX);
  std::uint64_t before = 0;
  std::size_t shard = 0;
  auto height = heights.begin(), image = images.begin();
  while (height != heights.end() || image != images.end()) {
    const bool is_height =
        image == images.end() || (height != heights.end() && height->place <= image->place);
    const Unit& unit = is_height ? *height++ : *image++;
    // A unit belongs to the shard in whose share its middle lies.
    const double middle = static_cast<double>(before) + static_cast<double>(unit.leaves) / 2;
    const auto own = std::min(shards - 1, static_cast<std::size_t>(middle * static_cast<double>(shards) /
                                                                   static_cast<double>(all)));
    for (; shard <= own; ++shard) first_places[shard] = unit.place;
    before += unit.leaves;
  }
  return first_places;
}

}  // namespace

DividedTiles divide_tiles(const TileTree* heights, const TileTree* imagery, std::size_t shards) {
  const std::vector<Unit> height_units = units_with_leaves(heights);
  const std::vector<Unit> image_units = units_with_leaves(imagery);
  const std::vector<std::uint64_t> first_places = places_between(height_units, image_units, shards);
  return {cut(height_units, heights != nullptr ? heights->top() : 0, first_places),
          cut(image_units, imagery != nullptr ? imagery->top() : 0, first_places)};
}

std::vector<TileId> units_of(const TileTree& tree, const ShardTiles& tiles) {
  std::vector<TileId> units;
  for (const TileId& subtree : tiles.subtrees) {
    const std::vector<TileId> of_subtree = tree.units(subtree);
    units.insert(units.end(), of_subtree.begin(), of_subtree.end());
  }
  return units;
}

}  // namespace cairn
