#include "builder/heights/height_layer.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "builder/heights/downsample.h"
#include "format/height_block.h"

namespace cairn {
namespace {

void add_counts(std::vector<std::uint64_t>& sum, const std::vector<std::uint64_t>& more) {
  sum.resize(std::max(sum.size(), more.size()));
  for (std::size_t s = 0; s < more.size(); ++s) sum[s] += more[s];
}

void add_stats(std::vector<ErrorStats>& sum, const std::vector<ErrorStats>& more) {
  for (std::size_t i = 0; i < std::min(sum.size(), more.size()); ++i) sum[i].add(more[i]);
}

// How far the child's posts are from the surfaces of its ancestors. Beyond the levels that were measured, the
// last error grows by as much as the surfaces differ.
std::vector<double> errors_above(const HeightNode& child, double quantum_m) {
  if (child.errors_m.size() > 1) return {child.errors_m.begin() + 1, child.errors_m.end()};
  return {child.errors_m.front() + decimation_error(child.tile) * quantum_m};
}

TileBlock block_of(const HeightNode& node) {
  const HeightTile& tile = node.tile;
  TileBlock out;
  IndexEntry& entry = out.entry;
  entry.layer = Layer::heights;
  entry.id = node.id;
  const HeightRange range = range_of(tile);
  entry.min_quanta = range.lowest;
  entry.max_quanta = range.highest;
  // Rounded up, so that the error bound survives the narrowing.
  entry.geometric_error_m = std::nextafter(static_cast<float>(node.errors_m.front()), HUGE_VALF);
  if (node.errors_m.front() == 0) entry.geometric_error_m = 0;
  entry.filled = static_cast<std::uint16_t>(std::lround(node.filled * 65535));
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

Result<SampledLeaf> HeightLayer::sample_leaf(const TileId& id) const {
  return cairn::sample_leaf(mosaic_, plan_, id, voids_);
}

HeightNode HeightLayer::measure_leaf(SampledLeaf leaf) const {
  return cairn::measure_leaf(mosaic_, plan_, std::move(leaf));
}

HeightNode HeightLayer::begin_parent(const TileId& id) const {
  HeightNode parent;
  parent.id = id;
  parent.edge_only = plan_.tree().edge_only(id);
  parent.tile = empty_parent(plan_.tile_size());
  parent.filled = 1;
  return parent;
}

void HeightLayer::merge_child(const HeightNode& child, HeightNode& parent) const {
  take_child(child.tile, quadrant_of(child.id), parent.tile);
  if (child.edge_only) return;
  parent.filled -= (1 - child.filled) / 4;
  parent.final_stats.add(child.final_stats);
  parent.has_stored = parent.has_stored || child.has_stored;
  add_counts(parent.posts_used, child.posts_used);
  add_counts(parent.posts_lost, child.posts_lost);

  const std::vector<double> errors = errors_above(child, plan_.quantum_m());
  if (parent.errors_m.empty()) {
    parent.errors_m = errors;
    parent.candidate_stats = child.has_stored ? std::vector<ErrorStats>(1) : child.candidate_stats;
    return;
  }
  parent.errors_m.resize(std::min(parent.errors_m.size(), errors.size()));
  for (std::size_t i = 0; i < parent.errors_m.size(); ++i)
    parent.errors_m[i] = std::max(parent.errors_m[i], errors[i]);
  parent.candidate_stats.resize(
      child.has_stored ? 1 : std::min(parent.candidate_stats.size(), child.candidate_stats.size()));
  add_stats(parent.candidate_stats, child.candidate_stats);
}

void HeightLayer::finish_parent(HeightNode& parent) const {
  cairn::close_parent(parent.tile);
}

bool HeightLayer::can_prune(const HeightNode& node) const {
  const bool parent_suffices =
      !node.has_stored && node.id.level > plan_.top() && node.candidate_stats.size() > 1;
  return node.edge_only || parent_suffices;
}

void HeightLayer::prune(HeightNode& node) const {
  if (!node.edge_only) node.candidate_stats.erase(node.candidate_stats.begin());
}

void HeightLayer::keep(HeightNode& node) const {
  assert(node.id.level <= plan_.finest());  // finer ones can always be pruned: measure_leaf() sees to it
  node.final_stats.add(node.candidate_stats.front());
  node.candidate_stats.clear();
  node.has_stored = true;
}

TileBlock HeightLayer::encode(const HeightNode& node) const {
  return block_of(node);
}

void HeightLayer::finish_root(const HeightNode& root) {
  summary_.accuracy.add(root.final_stats);
  add_counts(summary_.posts_used, root.posts_used);
  add_counts(summary_.posts_lost, root.posts_lost);
}

}  // namespace cairn
