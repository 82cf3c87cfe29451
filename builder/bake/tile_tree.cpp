#include "builder/bake/tile_tree.h"

#include <algorithm>

namespace cairn {
namespace {

constexpr int kLevelsInUnit = 2;
constexpr TileId kEarth{kMinLevel, 0, 0};

}  // namespace

bool TileTree::wants(const TileId& id) const {
  return is_valid(id) && leaf_level_(id).has_value();
}

bool TileTree::is_leaf(const TileId& id) const {
  return id.level >= top_ && finest_within(id) <= id.level;
}

// A tile that lends its edge is as fine as what lies beyond that edge.
int TileTree::finest_within(const TileId& id) const {
  if (const auto own = leaf_level_(id)) return *own;
  int finest = kMinLevel;
  for (const int dy : {-1, 0, 1}) {
    for (const int dx : {-1, 0, 1}) {
      const TileId beyond = neighbour_of(id, dx, dy);
      if (is_valid(beyond)) finest = std::max(finest, leaf_level_(beyond).value_or(kMinLevel));
    }
  }
  return finest;
}

bool TileTree::edge_only(const TileId& id) const {
  return id.level > top_ && is_valid(id) && touches_ && !leaf_level_(id) && touches_(id);
}

int TileTree::children_of(const TileId& id) const {
  int count = 0;
  for (int q = 0; q < 4; ++q) count += is_walked(child_of(id, q)) ? 1 : 0;
  return count;
}

// Visits the tiles below `id` from the top level on, depth first, until visit() says to go no deeper.
template <class Visit>
void TileTree::walk(const TileId& id, const Visit& visit) const {
  if (!is_walked(id)) return;
  if (id.level >= top_ && !visit(id)) return;
  for (int q = 0; q < 4; ++q) walk(child_of(id, q), visit);
}

std::vector<TileId> TileTree::units() const {
  return units(kEarth);
}

std::vector<TileId> TileTree::units(const TileId& subtree) const {
  std::vector<TileId> units;
  walk(subtree, [&](const TileId& id) {
    if (finest_within(id) - id.level > kLevelsInUnit) return true;
    units.push_back(id);
    return false;
  });
  return units;
}

std::vector<TileId> TileTree::leaves(const TileId& unit) const {
  std::vector<TileId> leaves;
  walk(unit, [&](const TileId& id) {
    if (!is_leaf(id)) return true;
    leaves.push_back(id);
    return false;
  });
  return leaves;
}

std::uint64_t TileTree::leaf_count() const {
  std::uint64_t count = 0;
  walk(kEarth, [&](const TileId& id) {
    if (!is_leaf(id)) return true;
    ++count;
    return false;
  });
  return count;
}

std::map<int, std::uint64_t> TileTree::tiles_by_level() const {
  std::map<int, std::uint64_t> count;
  walk(kEarth, [&](const TileId& id) {
    ++count[id.level];
    return !is_leaf(id);
  });
  return count;
}

}  // namespace cairn
