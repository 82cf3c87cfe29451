#include "builder/heights/height_layer.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "builder/heights/downsample.h"
#include "builder/heights/height_leaf.h"
#include "format/height_block.h"

namespace cairn {
namespace {

void add_stats(std::vector<ErrorStats>& sum, const std::vector<ErrorStats>& more) {
  for (std::size_t i = 0; i < std::min(sum.size(), more.size()); ++i) sum[i].add(more[i]);
}

// How far the child's posts are from the surfaces of its ancestors. Beyond the levels that were measured, the
// last error grows by as much as the surfaces differ.
std::vector<double> errors_above(const HeightNode& child, double quantum_m) {
  if (child.errors_m.size() > 1) return {child.errors_m.begin() + 1, child.errors_m.end()};
  return {child.errors_m.front() + decimation_error(child.tile) * quantum_m};
}

TileBlock block_of(const HeightNode& baked) {
  const HeightTile& tile = baked.tile;
  TileBlock out;
  IndexEntry& entry = out.entry;
  entry.layer = Layer::heights;
  entry.id = baked.id;
  const HeightRange range = range_of(tile);
  entry.min_quanta = range.lowest;
  entry.max_quanta = range.highest;
  // Rounded up, so that the error bound survives the narrowing.
  entry.geometric_error_m = std::nextafter(static_cast<float>(baked.errors_m.front()), HUGE_VALF);
  if (baked.errors_m.front() == 0) entry.geometric_error_m = 0;
  entry.filled = static_cast<std::uint16_t>(std::lround(baked.filled * 65535));
  const bool constant = tile.voids.empty() && entry.min_quanta == entry.max_quanta;
  if (constant) {
    entry.flags = kConstant;
    return out;
  }
  if (!tile.voids.empty()) entry.flags = kHasVoids;
  out.block = encode_height_block(tile, default_height_codec());
  return out;
}

}  // namespace

std::uint64_t HeightLayer::samples_a_tile() const {
  const auto intervals = static_cast<std::uint64_t>(plan_.tile_size() - 1);
  return intervals * intervals;
}

Result<HeightNode> HeightLayer::bake_leaf(const TileId& id) const {
  return cairn::bake_leaf(mosaic_, plan_, id, voids_);
}

HeightNode HeightLayer::open_parent(const TileId& id) const {
  HeightNode parent;
  parent.id = id;
  parent.edge_only = plan_.tree().edge_only(id);
  parent.tile = empty_parent(plan_.tile_size());
  parent.filled = 1;
  return parent;
}

Result<std::optional<TileBlock>> HeightLayer::settle(HeightNode& tile) const {
  if (tile.edge_only) return std::optional<TileBlock>{};
  const bool leave_out = !tile.has_stored && tile.id.level > plan_.top() && tile.open.size() > 1;
  if (leave_out) {
    tile.open.erase(tile.open.begin());
    return std::optional<TileBlock>{};
  }
  assert(tile.id.level <= plan_.finest());  // finer ones can always be left out: bake_leaf() sees to it
  tile.settled.add(tile.open.front());
  tile.open.clear();
  tile.has_stored = true;
  return std::optional<TileBlock>(block_of(tile));
}

void HeightLayer::take(const HeightNode& child, HeightNode& parent) const {
  take_child(child.tile, quadrant_of(child.id), parent.tile);
  if (child.edge_only) return;
  parent.filled -= (1 - child.filled) / 4;
  parent.settled.add(child.settled);
  parent.has_stored = parent.has_stored || child.has_stored;
  parent.posts_used.resize(child.posts_used.size());
  for (std::size_t s = 0; s < child.posts_used.size(); ++s) parent.posts_used[s] += child.posts_used[s];

  const std::vector<double> errors = errors_above(child, plan_.quantum_m());
  if (parent.errors_m.empty()) {
    parent.errors_m = errors;
    parent.open = child.has_stored ? std::vector<ErrorStats>(1) : child.open;
    return;
  }
  parent.errors_m.resize(std::min(parent.errors_m.size(), errors.size()));
  for (std::size_t i = 0; i < parent.errors_m.size(); ++i)
    parent.errors_m[i] = std::max(parent.errors_m[i], errors[i]);
  parent.open.resize(child.has_stored ? 1 : std::min(parent.open.size(), child.open.size()));
  add_stats(parent.open, child.open);
}

void HeightLayer::close_parent(HeightNode& parent) const {
  cairn::close_parent(parent.tile);
}

void HeightLayer::summarise(const HeightNode& root) {
  summary_.accuracy.add(root.settled);
  summary_.posts_used.resize(root.posts_used.size());
  for (std::size_t s = 0; s < root.posts_used.size(); ++s) summary_.posts_used[s] += root.posts_used[s];
}

}  // namespace cairn
