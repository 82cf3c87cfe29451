#include "builder/mosaic/source_grouping.h"

#include <algorithm>
#include <cmath>

#include "builder/mosaic/lattice_group.h"
#include "builder/mosaic/projected_group.h"
#include "builder/mosaic/source_order.h"

namespace cairn {
namespace {

// How close an iterative fit comes to the posts, as a share of the error bound; the rest is for rounding.
constexpr double kShareOfErrorBound = 0.1;
constexpr double kFinestDefaultErrorBound = 0.05;

struct LatticeMembers {
  Lattice lattice;
  int priority = 0;
  std::vector<LatticeGroup::Member> members;
};

double samples_per_degree(int level, int tile_size) {
  return static_cast<double>(tile_size - 1) / tile_width_degrees(level);
}

// The first level whose samples are as dense as the posts. A hair of tolerance: 3600.0000001 posts are 3600.
int level_for(double posts_per_degree, int tile_size) {
  int level = kMinLevel;
  while (level < kMaxLevel && samples_per_degree(level, tile_size) < posts_per_degree * (1 - 1e-9)) ++level;
  return level;
}

int lattice_level(const Lattice& lattice, ResampleMethod resampling, int tile_size) {
  int level = level_for(std::max(lattice.lon.posts_per_degree, lattice.lat.posts_per_degree), tile_size);
  const auto usable = [&](const LatticeAxis& axis) {
    return AxisResampler(axis, samples_per_degree(level, tile_size), resampling).is_well_conditioned();
  };
  while (level < kMaxLevel && !(usable(lattice.lon) && usable(lattice.lat))) ++level;
  return level;
}

int priority_of(const RasterInfo& info) {
  return info.overrides.priority.value_or(0);
}

void add_to_lattice(std::vector<LatticeMembers>& lattices, std::size_t source, int priority,
                    const LatticePlacement& placement) {
  for (LatticeMembers& l : lattices) {
    if (l.priority != priority || l.members.size() + 2 >= PostBlock::kVoid) continue;
    if (const auto rebased = rebase(placement, l.lattice)) {
      l.members.push_back({source, *rebased});
      return;
    }
  }
  lattices.push_back({placement.lattice, priority, {{source, placement}}});
}

// Sources that one grid holds, in the order of the command line.
void add_to_grid(std::vector<ProjectedGroup::Grid>& grids, std::size_t source, const RasterPool& pool) {
  const RasterInfo& info = pool.info(source);
  for (ProjectedGroup::Grid& grid : grids) {
    if (priority_of(pool.info(grid.members.front().source)) != priority_of(info)) continue;
    if (grid.members.size() + 2 >= PostBlock::kVoid) continue;
    if (const auto placement = place_on_grid(info, grid.georeference)) {
      grid.members.push_back({source, *placement});
      return;
    }
  }
  grids.push_back({info.georeference, {{source, {}}}});
}

// --level finer than the sources need: the finest groups are sampled there.
int asked_level(int native, int finest, const MosaicOptions& options) {
  return native == finest && options.level ? std::max(native, *options.level) : native;
}

}  // namespace

Result<std::vector<std::unique_ptr<SourceGroup>>> group_sources(RasterPool& pool, const Geoid* geoid,
                                                                const MosaicOptions& options, int tile_size,
                                                                std::shared_ptr<ChunkCache> blocks) {
  std::vector<LatticeMembers> lattices;
  std::vector<ProjectedGroup::Grid> grids;
  for (std::size_t s = 0; s < pool.size(); ++s) {
    if (const auto placement = place_on_lattice(pool.info(s))) {
      add_to_lattice(lattices, s, priority_of(pool.info(s)), *placement);
    } else {
      add_to_grid(grids, s, pool);
    }
  }
  int finest = kMinLevel;
  for (const auto& l : lattices)
    finest = std::max(finest, lattice_level(l.lattice, options.resampling, tile_size));
  for (const auto& g : grids) finest = std::max(finest, ProjectedGroup::level_for(pool, g, tile_size));

  std::vector<std::unique_ptr<SourceGroup>> groups;
  for (auto& l : lattices) {
    const int level = asked_level(lattice_level(l.lattice, options.resampling, tile_size), finest, options);
    groups.push_back(std::make_unique<LatticeGroup>(pool, geoid, l.lattice, std::move(l.members), level,
                                                    samples_per_degree(level, tile_size),
                                                    options.resampling));
  }
  const double error_bound_m = options.max_error_m.value_or(kFinestDefaultErrorBound);
  const double tolerance = error_bound_m * kShareOfErrorBound;
  for (auto& g : grids) {
    const int level = asked_level(ProjectedGroup::level_for(pool, g, tile_size), finest, options);
    groups.push_back(std::make_unique<ProjectedGroup>(pool, geoid, std::move(g), level, tile_size,
                                                      options.resampling, tolerance, blocks, groups.size()));
  }
  sort_by_priority(pool, groups);
  return groups;
}

}  // namespace cairn
