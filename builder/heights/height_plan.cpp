#include "builder/heights/height_plan.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace cairn {
namespace {

// The finest level of the leaves that lie across the region's rim, below a tile.
int finest_across_rim(const Mosaic& mosaic, const Footprint& wanted, const TileId& id) {
  const GeoBounds bounds = without_overhang(tile_bounds(id));
  if (!is_valid(id) || !wanted.overlaps(bounds) || wanted.contains(bounds)) return kMinLevel;
  const auto level = mosaic.leaf_level(id);
  if (!level) return kMinLevel;
  if (*level <= id.level) return id.level;
  int finest = kMinLevel;
  for (int q = 0; q < 4; ++q) finest = std::max(finest, finest_across_rim(mosaic, wanted, child_of(id, q)));
  return finest;
}

// Where the mosaic has something, and the region asks for it. All leaves across the region's rim have one
// level: a coarse one reaches farther beyond the rim than a fine one beside it, and their parents would
// differ along the edge between them.
TileTree::LeafLevel leaf_level_in(const Mosaic& mosaic, const std::optional<GeoBounds>& region) {
  if (!region) return [&mosaic](const TileId& id) { return mosaic.leaf_level(id); };
  Footprint wanted;
  wanted.add(*region);
  const int at_rim = finest_across_rim(mosaic, wanted, {kMinLevel, 0, 0});
  return [&mosaic, wanted, at_rim](const TileId& id) -> std::optional<int> {
    const GeoBounds bounds = without_overhang(tile_bounds(id));
    if (!wanted.overlaps(bounds)) return std::nullopt;
    const auto level = mosaic.leaf_level(id);
    if (!level || wanted.contains(bounds)) return level;
    return std::max(*level, at_rim);
  };
}

// Whether a tile lends its edge to its parent: where the mosaic has something at the edge, and nothing
// inside. Of a region's rim it lends nothing where a neighbour lies outside, which may need a finer level.
TileTree::Touches touches_in(const Mosaic& mosaic, const std::optional<GeoBounds>& region) {
  Footprint wanted;
  if (region) wanted.add(*region);
  const auto is_wanted = [wanted, everywhere = !region](const TileId& id) {
    return everywhere || wanted.overlaps(without_overhang(tile_bounds(id)));
  };
  return [&mosaic, is_wanted](const TileId& id) {
    if (!mosaic.touches(id) || mosaic.covers(id)) return false;
    for (const int dy : {-1, 0, 1}) {
      for (const int dx : {-1, 0, 1}) {
        const TileId beyond = neighbour_of(id, dx, dy);
        if (is_valid(beyond) && mosaic.covers(beyond) && !is_wanted(beyond)) return false;
      }
    }
    return true;
  };
}

}  // namespace

HeightPlan::HeightPlan(const Mosaic& mosaic)
    : mosaic_(&mosaic), error_bounds_(mosaic.error_bounds()), tree_(kMinLevel, leaf_level_in(mosaic, {})) {}

Status HeightPlan::choose_levels(const MosaicOptions& asked, const GridOptions& grid) {
  const int native = mosaic_->finest_level();
  finest_ = asked.level.value_or(native);
  const int top = grid.top.value_or(mosaic_->is_global() ? kMinLevel : std::min(0, finest_));
  tree_ = TileTree(top, leaf_level_in(*mosaic_, grid.region), touches_in(*mosaic_, grid.region));
  if (top > finest_) {
    return usage_error("top level: expected one no finer than the finest, " + std::to_string(finest_) +
                       ", found " + std::to_string(top));
  }
  return {};
}

// Where heights are stored as the sources have them, their own step keeps any error bound. Elsewhere rounding
// and smooth resampling share E. Steps of whole-metre sources are as coarse as leaves slopes, over the
// distance of two posts, less noise than the posts' own have (docs/resampling.md): where samples are much
// denser than posts, such a slope takes in more of them. Posts that are met exactly have steps of a quarter
// metre.
double HeightPlan::step_of_whole_metres(ResampleMethod resampling) const {
  constexpr double dense = 1.5;  // samples for each post
  if (mosaic_->posts_are_samples()) return 1;
  double samples_per_post = HUGE_VAL, bound = HUGE_VAL;
  for (std::size_t g = 0; g < mosaic_->groups().size(); ++g) {
    if (!mosaic_->whole_metres(g)) continue;
    samples_per_post = std::min(samples_per_post, mosaic_->groups()[g]->samples_per_post());
    bound = mosaic_->error_bound_m(g);
  }
  if (resampling != ResampleMethod::smooth) return std::min(0.25, bound / 2);
  return std::min(0.5, bound) * (samples_per_post >= dense ? 1.2 : 1);
}

// Where posts of whole metres lie beside others, all heights are in quanta that suit the finest, and those
// that whole metres alone decide are multiples of a step that suits these: the codec takes out a tile's step.
void HeightPlan::choose_quantum(const MosaicOptions& asked, const HeightOptions& heights) {
  bool any_whole = false, all_whole = true;
  for (std::size_t g = 0; g < mosaic_->groups().size(); ++g) {
    any_whole = any_whole || mosaic_->whole_metres(g);
    all_whole = all_whole && mosaic_->whole_metres(g);
  }
  const double step = any_whole ? step_of_whole_metres(asked.resampling) : 0;
  quantum_m_ = heights.quantum_m.value_or(all_whole ? step : std::min(0.02, error_bounds_.least_m / 2));
  if (heights.quantum_m || all_whole || !any_whole) return;
  constexpr double rounding = 1e-9;
  whole_metre_step_ = std::max(1, static_cast<int>(std::floor(step / quantum_m_ + rounding)));
}

SmoothTolerance HeightPlan::tolerance(std::size_t group) const {
  constexpr double float_rounding = 0.001;  // of samples at heights up to 16 km
  const double bound = error_bound_m(group);
  const double step = quantum_m_ * (mosaic_->whole_metres(group) ? whole_metre_step_ : 1);
  return {std::max(0.0, bound - step / 2 - float_rounding), bound / 2};
}

void HeightPlan::set_tolerances(Mosaic& mosaic) const {
  for (std::size_t g = 0; g < mosaic.groups().size(); ++g) mosaic.set_tolerance(g, tolerance(g));
}

Result<HeightPlan> HeightPlan::make(const Mosaic& mosaic, const MosaicOptions& asked,
                                    const HeightOptions& heights, const GridOptions& grid) {
  HeightPlan plan(mosaic);
  plan.tile_size_ = grid.tile_size;
  if (auto status = plan.choose_levels(asked, grid); !status) return status.error();
  plan.choose_quantum(asked, heights);
  if (plan.tree_.units().empty())
    return usage_error("region: expected an area that the sources cover, found none");
  return plan;
}

PostCounting HeightPlan::counting(const TileId& leaf) const {
  const auto lies = [&](int dx, int dy) { return tree_.wants(neighbour_of(leaf, dx, dy)); };
  PostCounting counting;
  counting.window = window_of(leaf, tile_size_);
  const SampleWindow& window = counting.window;
  counting.antimeridian = 360 * window.samples_per_degree - static_cast<double>(window.column);
  const bool east = lies(1, 0);
  const bool north = lies(0, 1);
  counting.count_east = !east;
  counting.count_north = !north;
  counting.count_north_west = !north && !lies(-1, 1);
  counting.count_north_east = !north && !east && !lies(1, 1);
  return counting;
}

}  // namespace cairn
