#include "runtime/scene/scene_map.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <iterator>

#include "runtime/scene/split_set.h"

namespace cairn {
namespace {

struct Name {
  RefinementPattern pattern;
  std::string_view word;
};
constexpr std::array<Name, 7> kNames{{{RefinementPattern::normal, "normal"},
                                      {RefinementPattern::plus, "plus"},
                                      {RefinementPattern::cross, "cross"},
                                      {RefinementPattern::restricted, "restricted"},
                                      {RefinementPattern::balanced, "balanced"},
                                      {RefinementPattern::nine, "nine"},
                                      {RefinementPattern::window, "window"}}};

/// The level of the nearest ancestor of `id` that can be had, `id` not counted.
std::int8_t inherited_level(TileId id, const HasTile& has) {
  while (id.level > kMinLevel) {
    id = parent_of(id);
    if (!has || has(id)) return static_cast<std::int8_t>(id.level);
  }
  return SceneTile::kNothing;
}

std::int8_t level_at(const TileId& id, std::int8_t inherited, const HasTile& has) {
  return !has || has(id) ? static_cast<std::int8_t>(id.level) : inherited;
}

/// Walks the tree that the splits describe, depth first, and keeps the leaves.
class Leaves {
 public:
  Leaves(const SplitSet& splits, const HasTile& has, SceneMap& out) : splits_(splits), has_(has), out_(out) {}

  void add_root(const TileId& id) { add(id, inherited_level(id, has_)); }

  void add(const TileId& id, std::int8_t inherited) {
    const std::int8_t level = level_at(id, inherited, has_);
    if (!splits_.contains(id)) {
      out_.push_back({id, level});
      return;
    }
    const std::size_t first = out_.size();
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const TileId child = child_of(id, quadrant);
      if (is_valid(child)) add(child, level);
    }
    if (all_inherit(first, id)) {
      out_.resize(first);
      out_.push_back({id, level});
    }
  }

 private:
  /// Whether the leaves from `first` on are children of `id` that show no data of their own.
  bool all_inherit(std::size_t first, const TileId& id) const {
    return std::all_of(out_.begin() + static_cast<std::ptrdiff_t>(first), out_.end(),
                       [&](const SceneTile& leaf) {
                         return leaf.area.level == id.level + 1 && leaf.source_level <= id.level;
                       });
  }

  const SplitSet& splits_;
  const HasTile& has_;
  SceneMap& out_;
};

SceneMap one_level(const TileId& eye, int west, int count, const HasTile& has) {
  SceneMap map;
  const int columns = std::min(count, tiles_around(eye.level));
  for (int dy = 0; dy < count; ++dy) {
    for (int dx = 0; dx < columns; ++dx) {
      const TileId id = neighbour_of(eye, dx + west, dy + west);
      if (!is_valid(id)) continue;
      map.push_back({id, level_at(id, inherited_level(id, has), has)});
    }
  }
  return map;
}

SceneMap quadtree(const SceneMapSpec& spec, const HasTile& has) {
  const SplitSet splits = mark_splits(spec);
  SceneMap map;
  map.reserve(128);
  Leaves leaves(splits, has, map);
  if (spec.coarsest == kMinLevel) {
    leaves.add_root({kMinLevel, 0, 0});
    return map;
  }
  for (const TileId& root : splits.at(spec.coarsest - 1)) {
    for (int quadrant = 0; quadrant < 4; ++quadrant) {
      const TileId child = child_of(root, quadrant);
      if (is_valid(child)) leaves.add_root(child);
    }
  }
  return map;
}

}  // namespace

std::span<const RefinementPattern> all_refinement_patterns() {
  static constexpr auto all = [] {
    std::array<RefinementPattern, kNames.size()> patterns{};
    std::transform(kNames.begin(), kNames.end(), patterns.begin(), [](const Name& n) { return n.pattern; });
    return patterns;
  }();
  return all;
}

std::string_view to_string(RefinementPattern pattern) {
  return kNames[static_cast<std::size_t>(pattern)].word;
}

std::optional<RefinementPattern> refinement_pattern_from(std::string_view word) {
  for (const Name& name : kNames) {
    if (name.word == word) return name.pattern;
  }
  return std::nullopt;
}

SceneMap build_scene_map(const SceneMapSpec& spec, const HasTile& has) {
  assert(is_valid(spec.eye) && spec.coarsest >= kMinLevel && spec.coarsest <= spec.eye.level);
  assert(spec.window_tiles >= 1 && spec.window_tiles <= 64);
  SceneMap map;
  switch (spec.pattern) {
    case RefinementPattern::nine:
      map = one_level(spec.eye, -1, 3, has);
      break;
    case RefinementPattern::window:
      map = one_level(spec.eye, -(spec.window_tiles / 2), spec.window_tiles, has);
      break;
    default:
      map = quadtree(spec, has);
  }
  std::sort(map.begin(), map.end());
  return map;
}

std::vector<TileId> sources_of(const SceneMap& map) {
  std::vector<TileId> sources;
  sources.reserve(map.size());
  for (const SceneTile& tile : map) {
    if (tile.has_source()) sources.push_back(tile.source());
  }
  std::sort(sources.begin(), sources.end());
  sources.erase(std::unique(sources.begin(), sources.end()), sources.end());
  return sources;
}

std::vector<TileId> difference(std::span<const TileId> before, std::span<const TileId> after) {
  std::vector<TileId> fresh;
  std::set_difference(after.begin(), after.end(), before.begin(), before.end(), std::back_inserter(fresh));
  return fresh;
}

}  // namespace cairn
