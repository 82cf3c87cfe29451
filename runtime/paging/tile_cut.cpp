#include "runtime/paging/tile_cut.h"

#include <cassert>

#include "runtime/paging/tile_availability.h"

namespace cairn {
namespace {

bool contains(const TileId& outer, const TileId& inner) {
  return outer.level <= inner.level && ancestor_of(inner, outer.level) == outer;
}

std::size_t count_inside(const TileId& outer, const TileCut& cover, std::size_t first) {
  std::size_t end = first;
  while (end < cover.size() && contains(outer, cover[end].area)) ++end;
  return end - first;
}

}  // namespace

CutNode make_cut_node(const TileId& area, const TileAvailability& contents, const Occluder& occluder,
                      bool has_finer_heights) {
  CutNode node{area, contents.nearest(Layer::heights, area), contents.nearest(Layer::imagery, area), {}};
  const double quantum_m = contents.pack().header().quantum_m;
  double low_m = 0, high_m = 0;
  if (node.heights) {
    const double error_m = has_finer_heights ? static_cast<double>(node.heights->geometric_error_m) : 0;
    low_m = node.heights->min_quanta * quantum_m - error_m;
    high_m = node.heights->max_quanta * quantum_m + error_m;
  }
  node.volume = bounding_volume(tile_bounds(area), low_m, high_m, occluder);
  return node;
}

std::vector<CutChange> changes_between(const TileCut& before, const TileCut& after) {
  std::vector<CutChange> changes;
  std::size_t i = 0, j = 0;
  while (i < before.size() && j < after.size()) {
    CutChange change{i, 1, j, 1};
    if (before[i].area.level <= after[j].area.level) {
      change.new_count = count_inside(before[i].area, after, j);
    } else {
      change.old_count = count_inside(after[j].area, before, i);
    }
    assert(change.old_count > 0 && change.new_count > 0);
    if (!before[i].shows_same(after[j])) changes.push_back(change);
    i += change.old_count;
    j += change.new_count;
  }
  return changes;
}

}  // namespace cairn
