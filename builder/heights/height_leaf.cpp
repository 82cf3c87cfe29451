#include "builder/heights/height_leaf.h"

#include <algorithm>
#include <cmath>

#include "builder/heights/leaf_error.h"
#include "builder/heights/quantize_tile.h"
#include "format/simd_clones.h"

namespace cairn {
namespace {

// Measures level by level, upwards. Posts stay open for as long as tiles may be left out: because the coarser
// surface keeps the error bound too, or because the level is finer than any that is stored.
void measure_levels(const HeightPlan& plan, const MosaicTile& mosaic, HeightNode& baked) {
  const PostCounting counting = plan.counting(baked.id);
  const LeafErrors meter(baked.tile, plan.quantum_m(), mosaic.posts, counting);
  baked.open.push_back(meter.own_stats());
  baked.errors_m.push_back(meter.own().max_m);
  bool open = true;
  for (int up = 1; baked.id.level - up >= plan.top() && (plan.tile_size() - 1) % (1 << up) == 0; ++up) {
    const double max_m = meter.max_m(up);
    const bool too_fine = baked.id.level - up >= plan.finest();
    open = open && (too_fine || meter.keeps(up, plan.error_bound_m(), max_m));
    if (open) baked.open.push_back(meter.stats(up, max_m));
    baked.errors_m.push_back(std::max(max_m, baked.errors_m.back()));
  }
}

CAIRN_SIMD_CLONES bool any_other_or_void(const std::uint16_t* owners, const float* heights,
                                         std::size_t count) {
  int other = 0;  // no early end, so that the loop is one of vectors
  for (std::size_t i = 0; i < count; ++i)
    other |= (owners[i] ^ owners[0]) | (heights[i] != heights[i] ? 1 : 0);
  return other != 0;
}

// Whether one source gave all the posts, none of which is void or has lost.
bool is_of_one_source(const MeasuredPosts& posts) {
  if (posts.owners.empty() || !posts.placed.empty()) return false;
  return !any_other_or_void(posts.owners.data(), posts.heights.data(), posts.owners.size());
}

void count_winners_of(const MeasuredPosts& posts, const std::vector<std::size_t>& sources,
                      const PostCounting& counting, std::vector<std::uint64_t>& won) {
  if (is_of_one_source(posts)) {
    won[sources[posts.owners.front() - 1u]] += counting.count(posts);
    return;
  }
  for (std::size_t r = 0; r < posts.ys.size(); ++r) {
    for (std::size_t c = 0; c < posts.xs.size(); ++c) {
      const std::size_t post = r * posts.xs.size() + c;
      if (std::isnan(posts.heights[post]) || !counting.counts(posts.xs[c], posts.ys[r])) continue;
      ++won[sources[posts.owners[post] - 1u]];
    }
  }
  for (const auto& p : posts.placed) {
    if (counting.counts(p.x, p.y)) ++won[sources[p.owner - 1u]];
  }
}

std::vector<std::uint64_t> count_winners(const Mosaic& mosaic, const MosaicTile& tile,
                                         const PostCounting& counting) {
  std::vector<std::uint64_t> won(mosaic.pool().size(), 0);
  for (std::size_t g = 0; g < tile.posts.size(); ++g)
    count_winners_of(tile.posts[g], mosaic.groups()[tile.groups[g]]->sources(), counting, won);
  return won;
}

}  // namespace

Result<HeightNode> bake_leaf(const Mosaic& mosaic, const HeightPlan& plan, const TileId& id, VoidMode voids) {
  const auto sampled = mosaic.sample(id);
  if (!sampled) return sampled.error();
  QuantizedTile cut = quantize_tile(*sampled, plan.tile_size(), plan.quantum_m(), voids);
  HeightNode baked;
  baked.id = id;
  baked.tile = std::move(cut.tile);
  baked.filled = cut.filled;
  baked.edge_only = plan.tree().edge_only(id);
  if (baked.edge_only) return baked;
  measure_levels(plan, *sampled, baked);
  baked.posts_used = count_winners(mosaic, *sampled, plan.counting(id));
  return baked;
}

}  // namespace cairn
