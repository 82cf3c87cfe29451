#include "runtime/paging/tile_tree.h"

#include <utility>

namespace cairn {
namespace {

constexpr std::size_t kManyNodes = 2000;  // some 1 MiB

}  // namespace

const TileTree::Node& TileTree::node(const TileId& area) const {
  if (!nodes_.contains(area)) nodes_.insert(older_.extract(area));
  const auto [found, fresh] = nodes_.try_emplace(area);
  Node& node = found->second;
  if (!fresh) return node;
  node.is_above_tiles = contents_.is_above_tiles(area);
  node.has_finer_heights = has_children(Layer::heights, area);
  node.has_finer_imagery = has_children(Layer::imagery, area);
  node.best = make_cut_node(area, contents_, occluder_, node.has_finer_heights);
  return node;
}

bool TileTree::has_children(Layer layer, const TileId& area) const {
  const auto levels = contents_.pack().levels(layer);
  if (!levels || area.level >= levels->finest) return false;
  if (area.level + 1 < levels->coarsest) return contents_.is_above_tiles(area);
  for (int quadrant = 0; quadrant < 4; ++quadrant) {
    const TileId child = child_of(area, quadrant);
    if (is_valid(child) && contents_.pack().find_index(layer, child)) return true;
  }
  return false;
}

void TileTree::trim() {
  if (nodes_.size() <= kManyNodes) return;
  older_ = std::move(nodes_);
  nodes_.clear();
}

}  // namespace cairn
