#include "builder/pyramid.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "builder/downsample.h"
#include "format/height_block.h"

namespace cairn {
namespace {

void add_stats(std::vector<PostStats>& sum, const std::vector<PostStats>& more) {
  for (std::size_t i = 0; i < std::min(sum.size(), more.size()); ++i) sum[i].add(more[i]);
}

// How far the child's posts are from the surfaces of its ancestors. Beyond the levels that were measured, the
// last error grows by as much as the surfaces differ.
std::vector<double> errors_above(const BakedTile& child, double quantum_m) {
  if (child.errors_m.size() > 1) return {child.errors_m.begin() + 1, child.errors_m.end()};
  return {child.errors_m.front() + decimation_error(child.tile) * quantum_m};
}

TileBlock block_of(const BakedTile& baked) {
  const HeightTile& tile = baked.tile;
  TileBlock out;
  IndexEntry& entry = out.entry;
  entry.layer = Layer::heights;
  entry.id = baked.id;
  bool any = false;
  for (std::size_t i = 0; i < tile.samples.size(); ++i) {
    if (!tile.voids.empty() && tile.voids[i] != 0) continue;
    entry.min_quanta = any ? std::min(entry.min_quanta, tile.samples[i]) : tile.samples[i];
    entry.max_quanta = any ? std::max(entry.max_quanta, tile.samples[i]) : tile.samples[i];
    any = true;
  }
  // Rounded up, so that the promise survives the narrowing.
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

Pyramid::Pyramid(const BuildPlan& plan, int root_level, Emit emit)
    : plan_(plan), root_level_(root_level), emit_(std::move(emit)) {}

Status Pyramid::settle(BakedTile& tile) {
  const bool leave_out = !tile.has_stored && tile.id.level > plan_.top() && tile.open.size() > 1;
  if (leave_out) {
    tile.open.erase(tile.open.begin());
    return {};
  }
  assert(tile.id.level <= plan_.finest());  // finer ones can always be left out: bake_leaf() sees to it
  tile.settled.add(tile.open.front());
  tile.open.clear();
  tile.has_stored = true;
  return emit_(block_of(tile));
}

void Pyramid::take(const BakedTile& child, OpenParent& into) const {
  BakedTile& parent = into.parent;
  take_child(child.tile, quadrant_of(child.id), parent.tile);
  parent.filled -= (1 - child.filled) / 4;
  parent.settled.add(child.settled);
  parent.has_stored = parent.has_stored || child.has_stored;
  parent.posts_won.resize(child.posts_won.size());
  for (std::size_t s = 0; s < child.posts_won.size(); ++s) parent.posts_won[s] += child.posts_won[s];

  const std::vector<double> errors = errors_above(child, plan_.quantum_m());
  if (into.children++ == 0) {
    parent.errors_m = errors;
    parent.open = child.has_stored ? std::vector<PostStats>(1) : child.open;
    return;
  }
  parent.errors_m.resize(std::min(parent.errors_m.size(), errors.size()));
  for (std::size_t i = 0; i < parent.errors_m.size(); ++i)
    parent.errors_m[i] = std::max(parent.errors_m[i], errors[i]);
  parent.open.resize(child.has_stored ? 1 : std::min(parent.open.size(), child.open.size()));
  add_stats(parent.open, child.open);
}

Result<std::optional<BakedTile>> Pyramid::add(BakedTile child) {
  while (child.id.level > root_level_) {
    if (auto status = settle(child); !status) return status.error();
    const TileId parent_id = parent_of(child.id);
    if (open_.empty() || open_.back().parent.id != parent_id) {
      OpenParent fresh;
      fresh.parent.id = parent_id;
      fresh.parent.tile = empty_parent(plan_.tile_size());
      fresh.parent.filled = 1;
      fresh.waiting_for = plan_.children_of(parent_id);
      open_.push_back(std::move(fresh));
    }
    OpenParent& into = open_.back();
    take(child, into);
    if (--into.waiting_for > 0) return std::optional<BakedTile>{};
    close_parent(into.parent.tile);
    child = std::move(into.parent);
    open_.pop_back();
  }
  return std::optional<BakedTile>(std::move(child));
}

}  // namespace cairn
