#include "runtime/scene/split_set.h"

#include <algorithm>
#include <array>
#include <span>

namespace cairn {
namespace {

struct Step {
  int dx;
  int dy;
};
constexpr std::array<Step, 9> kAround{
    {{0, 0}, {1, 0}, {0, 1}, {-1, 0}, {0, -1}, {1, 1}, {-1, 1}, {-1, -1}, {1, -1}}};
constexpr std::span<const Step> kOwn{kAround.data(), 1};
constexpr std::span<const Step> kPlus{kAround.data(), 5};
// The parents of the diagonal neighbours are those of all neighbours, except beside the antimeridian at
// levels whose last tile overhangs, where the eye's own column may have a parent to itself.
constexpr std::span<const Step> kCross{kAround};

TileId clipped_neighbour(const TileId& id, const Step& step) {
  const std::int32_t top = tiles_pole_to_pole(id.level) - 1;
  return neighbour_of(id, step.dx, std::clamp(id.y + step.dy, 0, top) - id.y);
}

int coarsest_split(const SceneMapSpec& spec) {
  return std::max(spec.coarsest - 1, kMinLevel);
}

void mark_paths(const SceneMapSpec& spec, std::span<const Step> marks, SplitSet& splits) {
  for (const Step& mark : marks) {
    TileId id = clipped_neighbour(spec.eye, mark);
    while (id.level > coarsest_split(spec)) {
      id = parent_of(id);
      if (!splits.insert(id)) break;
    }
  }
}

void mark_every_level(const SceneMapSpec& spec, SplitSet& splits) {
  for (int level = spec.eye.level; level > coarsest_split(spec); --level) {
    const TileId eye = ancestor_of(spec.eye, level);
    for (const Step& mark : kCross) splits.insert(parent_of(clipped_neighbour(eye, mark)));
  }
}

/// A split tile needs all its neighbours to exist: their parents are split too, coarser and coarser.
void balance(const SceneMapSpec& spec, SplitSet& splits) {
  for (int level = spec.eye.level - 1; level > coarsest_split(spec); --level) {
    for (const TileId& split : splits.at(level)) {
      for (const Step& step : kAround) splits.insert(parent_of(clipped_neighbour(split, step)));
    }
  }
}

}  // namespace

bool SplitSet::contains(const TileId& id) const {
  const auto& level = levels_[index(id.level)];
  return std::find(level.begin(), level.end(), id) != level.end();
}

bool SplitSet::insert(const TileId& id) {
  if (contains(id)) return false;
  levels_[index(id.level)].push_back(id);
  return true;
}

SplitSet mark_splits(const SceneMapSpec& spec) {
  SplitSet splits;
  switch (spec.pattern) {
    case RefinementPattern::plus:
      mark_paths(spec, kPlus, splits);
      break;
    case RefinementPattern::cross:
      mark_paths(spec, kCross, splits);
      break;
    case RefinementPattern::restricted:
      mark_every_level(spec, splits);
      break;
    case RefinementPattern::balanced:
      mark_every_level(spec, splits);
      balance(spec, splits);
      break;
    default:
      mark_paths(spec, kOwn, splits);
  }
  return splits;
}

}  // namespace cairn
