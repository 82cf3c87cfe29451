#include "builder/leaf.h"

#include <algorithm>
#include <cmath>

#include "builder/geometric_error.h"
#include "builder/tile_cutter.h"

namespace cairn {
namespace {

SurfaceError worse_of(const SurfaceError& a, const SurfaceError& b) {
  return {std::max(a.max_m, b.max_m), a.has_holes || b.has_holes};
}

SurfaceError measure(const BakedTile& baked, double quantum_m, int up, const MosaicTile& mosaic) {
  SurfaceError worst;
  for (const auto& posts : mosaic.posts)
    worst = worse_of(worst, measure_surface(baked.tile, quantum_m, up, posts));
  return worst;
}

PostStats count(const BakedTile& baked, double quantum_m, int up, const MosaicTile& mosaic,
                const PostCounting& counting, SurfaceError& worst) {
  PostStats stats;
  for (const auto& posts : mosaic.posts) {
    worst = worse_of(worst, measure_surface(baked.tile, quantum_m, up, posts, counting, stats));
  }
  return stats;
}

// Measures level by level, upwards. Posts stay open for as long as tiles may be left out: because the coarser
// surface keeps the promise too, or because the level is finer than any that is stored.
void measure_levels(const BuildPlan& plan, const MosaicTile& mosaic, BakedTile& baked) {
  const PostCounting counting = plan.counting(baked.id);
  const double quantum = plan.quantum_m();
  SurfaceError own;
  baked.open.push_back(count(baked, quantum, 0, mosaic, counting, own));
  baked.errors_m.push_back(own.max_m);
  bool open = true;
  for (int up = 1; baked.id.level - up >= plan.top() && (plan.tile_size() - 1) % (1 << up) == 0; ++up) {
    SurfaceError error = measure(baked, quantum, up, mosaic);
    const bool too_fine = baked.id.level - up >= plan.finest();
    open = open && (too_fine || (error.max_m <= plan.promise_m() && !error.has_holes));
    if (open) baked.open.push_back(count(baked, quantum, up, mosaic, counting, error));
    baked.errors_m.push_back(std::max(error.max_m, baked.errors_m.back()));
  }
}

std::vector<std::uint64_t> count_winners(const Mosaic& mosaic, const MosaicTile& tile,
                                         const PostCounting& counting) {
  std::vector<std::uint64_t> won(mosaic.pool().size(), 0);
  const double last = counting.window.columns - 1;
  for (std::size_t g = 0; g < tile.posts.size(); ++g) {
    const auto& sources = mosaic.groups()[tile.groups[g]]->sources();
    const MeasuredPosts& posts = tile.posts[g];
    // Within the tile every post counts; only its last row and column have to be asked.
    std::vector<std::uint8_t> inside(posts.xs.size());
    for (std::size_t c = 0; c < inside.size(); ++c) inside[c] = posts.xs[c] < last ? 1 : 0;
    for (std::size_t r = 0; r < posts.ys.size(); ++r) {
      const bool asks = posts.ys[r] >= last;
      for (std::size_t c = 0; c < posts.xs.size(); ++c) {
        const std::size_t post = r * posts.xs.size() + c;
        if (std::isnan(posts.heights[post])) continue;
        if ((!asks && inside[c] != 0) || counting.counts(posts.xs[c], posts.ys[r]))
          ++won[sources[posts.owners[post] - 1u]];
      }
    }
    for (const auto& p : posts.placed) {
      if (counting.counts(p.x, p.y)) ++won[sources[p.owner - 1u]];
    }
  }
  return won;
}

}  // namespace

Result<BakedTile> bake_leaf(const Mosaic& mosaic, const BuildPlan& plan, const TileId& id, VoidMode voids) {
  const auto sampled = mosaic.sample(id);
  if (!sampled) return sampled.error();
  CutTile cut = cut_tile(*sampled, plan.tile_size(), plan.quantum_m(), voids);
  BakedTile baked;
  baked.id = id;
  baked.tile = std::move(cut.tile);
  baked.filled = cut.filled;
  baked.lends_edge = plan.tree().lends_edge(id);
  if (baked.lends_edge) return baked;
  measure_levels(plan, *sampled, baked);
  baked.posts_won = count_winners(mosaic, *sampled, plan.counting(id));
  return baked;
}

}  // namespace cairn
