#include "builder/heights/measure_pack.h"

#include <string>

#include "builder/bake/memory_budget.h"
#include "builder/bake/pipeline.h"
#include "builder/heights/geometric_error.h"
#include "builder/heights/height_plan.h"
#include "builder/mosaic/mosaic.h"

namespace cairn {
namespace {

constexpr std::size_t kInFlight = 8;

// The part of an ancestor's surface that lies over the tile, as a tile of its own; posts move with it.
struct Surface {
  HeightTile tile;
  int levels = 0;  // how much coarser than the posts' tile it is
  double x0 = 0;   // of the posts' tile in the surface's samples
  double y0 = 0;
};

MeasuredPosts moved(MeasuredPosts posts, const Surface& s) {
  const double scale = 1.0 / static_cast<double>(std::int64_t{1} << s.levels);
  for (double& x : posts.xs) x = s.x0 + x * scale;
  for (double& y : posts.ys) y = s.y0 + y * scale;
  for (auto& p : posts.placed) {
    p.x = s.x0 + p.x * scale;
    p.y = s.y0 + p.y * scale;
  }
  return posts;
}

Result<Surface> surface_over(const PackReader& pack, const TileId& id) {
  const auto entry = pack.find_nearest(Layer::heights, id);
  if (!entry)
    return bad_data(pack.path().string() + ": " + to_string(id) +
                    ": expected a tile or an ancestor, found none");
  auto tile = pack.read_height_tile(*entry);
  if (!tile) return tile.error();
  const int levels = id.level - entry->id.level;
  const double intervals = tile->size - 1;
  const double width = intervals / static_cast<double>(std::int64_t{1} << levels);
  const auto offset = [&](std::int32_t fine, std::int32_t coarse) {
    return static_cast<double>(fine - (std::int64_t{coarse} << levels)) * width;
  };
  return Surface{std::move(*tile), levels, offset(id.x, entry->id.x), offset(id.y, entry->id.y)};
}

// Posts are counted where the bake counted them: by their place in their own tile.
PostCounting counting_on(const PostCounting& own, const Surface& s) {
  PostCounting counting = own;
  const double scale = static_cast<double>(std::int64_t{1} << s.levels);
  counting.x0 = s.x0;
  counting.y0 = s.y0;
  counting.scale = scale;
  return counting;
}

Result<ErrorStats> measure_leaf(const Mosaic& mosaic, const HeightPlan& plan, const PackReader& pack,
                                const TileId& id) {
  const auto sampled = mosaic.sample(id);
  if (!sampled) return sampled.error();
  const auto surface = surface_over(pack, id);
  if (!surface) return surface.error();
  ErrorStats stats;
  const PostCounting counting = counting_on(plan.counting(id), *surface);
  for (std::size_t g = 0; g < sampled->posts.size(); ++g) {
    stats.add_bounded(plan.error_bound_m(sampled->groups[g]), [&](ErrorStats& of_group) {
      measure_surface(surface->tile, pack.header().quantum_m, 0, moved(sampled->posts[g], *surface), counting,
                      of_group);
    });
  }
  return stats;
}

}  // namespace

Result<ErrorStats> measure_pack(const PackReader& pack, const MosaicOptions& asked,
                                const HeightOptions& heights, const GridOptions& grid,
                                const SessionOptions& session, const ProgressCallback& progress) {
  const auto mosaic = Mosaic::open(asked, grid.tile_size);
  if (!mosaic) return mosaic.error();
  const bool projected = (*mosaic)->has_projected_sources();
  (*mosaic)->set_cache_bytes(
      cache_within(session.memory_bytes, {session.threads, grid.tile_size, false, projected, false}));
  const auto plan = HeightPlan::make(**mosaic, asked, heights, grid);
  if (!plan) return plan.error();
  plan->set_tolerances(**mosaic);
  std::vector<TileId> leaves;
  for (const TileId& unit : plan->tree().units()) {
    for (const TileId& leaf : plan->tree().leaves(unit)) leaves.push_back(leaf);
  }
  ErrorStats all;
  const auto samples =
      static_cast<std::uint64_t>(grid.tile_size) * static_cast<std::uint64_t>(grid.tile_size);
  const auto status = run_in_order<ErrorStats>(
      0, leaves.size(), kInFlight,
      [&](std::size_t i) { return measure_leaf(**mosaic, *plan, pack, leaves[i]); },
      [&](std::size_t i, ErrorStats&& stats) -> Status {
        all.add(stats);
        if (progress({"verify", (i + 1) * samples, leaves.size() * samples, 0})) return {};
        return failed(pack.path().string() + ": the measurement was cancelled");
      });
  if (!status) return status.error();
  return all;
}

}  // namespace cairn
