#include "builder/build_plan.h"

#include <algorithm>
#include <string>

namespace cairn {
namespace {

constexpr int kLevelsInUnit = 2;
constexpr TileId kEarth{kMinLevel, 0, 0};

}  // namespace

Status BuildPlan::choose_levels(const BuildOptions& options) {
  const int native = mosaic_->finest_level();
  finest_ = options.level.value_or(native);
  top_ = options.top.value_or(mosaic_->is_global() ? kMinLevel : std::min(0, finest_));
  if (top_ > finest_) {
    return usage_error("--top " + std::to_string(top_) + ": expected a level no finer than the finest, " +
                       std::to_string(finest_));
  }
  return {};
}

// Where heights are stored as the sources have them, their own step keeps any promise. Elsewhere the rounding
// may use up half of E at most; for whole metres a quarter keeps slopes smooth between the posts.
Status BuildPlan::choose_quantum(const BuildOptions& options) {
  const bool whole = mosaic_->whole_metres();
  promise_m_ = options.max_error_m.value_or(whole ? 0.5 : 0.05);
  const double step = whole && mosaic_->posts_are_samples() ? 1.0 : whole ? 0.25 : 0.02;
  quantum_m_ = options.quantum_m.value_or(
      whole && mosaic_->posts_are_samples() ? 1.0 : std::min(step, promise_m_ / 2));
  return {};
}

Result<BuildPlan> BuildPlan::make(const Mosaic& mosaic, const BuildOptions& options) {
  BuildPlan plan(mosaic);
  plan.tile_size_ = options.tile_size;
  plan.region_ = options.region;
  if (auto status = plan.choose_levels(options); !status) return status.error();
  if (auto status = plan.choose_quantum(options); !status) return status.error();
  if (!plan.wants(kEarth))
    return usage_error("--region: expected an area that the sources cover, found none");
  return plan;
}

bool BuildPlan::wants(const TileId& id) const {
  if (!is_valid(id) || !mosaic_->covers(id)) return false;
  if (!region_) return true;
  Footprint region;
  region.add(*region_);
  return region.overlaps(tile_bounds(id));
}

bool BuildPlan::is_leaf(const TileId& id) const {
  return id.level >= top_ && mosaic_->leaf_level(id).value_or(kMinLevel) <= id.level;
}

int BuildPlan::children_of(const TileId& id) const {
  int count = 0;
  for (int q = 0; q < 4; ++q) count += wants(child_of(id, q)) ? 1 : 0;
  return count;
}

PostCounting BuildPlan::counting(const TileId& leaf) const {
  const auto lies = [&](int dx, int dy) { return wants(neighbour_of(leaf, dx, dy)); };
  PostCounting counting;
  counting.window = window_of(leaf, tile_size_);
  const bool east = lies(1, 0);
  const bool north = lies(0, 1);
  counting.count_east = !east;
  counting.count_north = !north;
  counting.count_north_west = !north && !lies(-1, 1);
  counting.count_north_east = !north && !east && !lies(1, 1);
  return counting;
}

// Visits the wanted tiles below `id` from the top level on, depth first, until visit() says to go no deeper.
template <class Visit>
void BuildPlan::walk(const TileId& id, const Visit& visit) const {
  if (!wants(id)) return;
  if (id.level >= top_ && !visit(id)) return;
  for (int q = 0; q < 4; ++q) walk(child_of(id, q), visit);
}

std::vector<TileId> BuildPlan::units() const {
  std::vector<TileId> units;
  walk(kEarth, [&](const TileId& id) {
    if (*mosaic_->leaf_level(id) - id.level > kLevelsInUnit) return true;
    units.push_back(id);
    return false;
  });
  return units;
}

std::vector<TileId> BuildPlan::leaves(const TileId& unit) const {
  std::vector<TileId> leaves;
  walk(unit, [&](const TileId& id) {
    if (!is_leaf(id)) return true;
    leaves.push_back(id);
    return false;
  });
  return leaves;
}

std::uint64_t BuildPlan::leaf_count() const {
  std::uint64_t count = 0;
  walk(kEarth, [&](const TileId& id) {
    if (!is_leaf(id)) return true;
    ++count;
    return false;
  });
  return count;
}

std::map<int, std::uint64_t> BuildPlan::tiles_by_level() const {
  std::map<int, std::uint64_t> count;
  walk(kEarth, [&](const TileId& id) {
    ++count[id.level];
    return !is_leaf(id);
  });
  return count;
}

}  // namespace cairn
