#include "builder/export/quantized_mesh_plan.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include <fmt/format.h>

namespace cairn {
namespace {

constexpr double kRootError_m = 77067.33961626285;  // on the Earth
constexpr int kMostLevel = 30;
/// Coarser tiles are off the ellipsoid by metres between their vertices.
constexpr int kLeastCloseLevel = 8;
constexpr double kSteps = 32767;  // of a tile's height range
/// A level is kept where the pack's own error leaves this share of the bound for the mesh.
constexpr double kShareOfPack = 0.8;

std::vector<TickRect> rects_of(const GeoBounds& region) {
  const auto tick = [](double degrees, double origin, double (*snap)(double)) {
    return static_cast<std::int64_t>(snap(std::ldexp(degrees - origin, kTickBits)));
  };
  std::vector<TickRect> rects;
  for (const double turn : {-360.0, 0.0, 360.0}) {
    const TickRect rect =
        intersection({tick(region.west + turn, -180, std::floor), tick(region.south, -90, std::floor),
                      tick(region.east + turn, -180, std::ceil), tick(region.north, -90, std::ceil)},
                     {0, 0, kTicksAround, kTicksPoleToPole});
    if (rect.width() > 0 && rect.height() > 0) rects.push_back(rect);
  }
  return rects;
}

}  // namespace

double assumed_error_m(int level, const Ellipsoid& ellipsoid) {
  return std::ldexp(kRootError_m * (ellipsoid.semi_major_m / Ellipsoid().semi_major_m), -level);
}

Result<QuantizedMeshPlan> QuantizedMeshPlan::make(const PackReader& pack, const PackPatches& patches,
                                                  std::optional<double> finest_error_m,
                                                  const Options& options) {
  const auto intervals = static_cast<unsigned>(pack.header().tile_size - 1);
  QuantizedMeshPlan plan(patches, std::countr_zero(intervals));
  plan.max_error_m_ = options.max_error_m;
  if (options.region) plan.regions_ = rects_of(*options.region);
  if (options.region && !plan.has_data({0, 0, kTicksAround, kTicksPoleToPole}, patches.coarsest()))
    return failed(pack.path().string() + ": expected heights in the region, the pack has none");
  plan.finest_ =
      std::min({patches.finest() + plan.interval_bits_ + 2, options.finest.value_or(kMostLevel), kMostLevel});
  double own_error = finest_error_m.value_or(0);
  if (!finest_error_m) {
    for (std::size_t i = 0; i < pack.entry_count(); ++i)
      if (const IndexEntry entry = pack.entry(i);
          entry.layer == Layer::heights && entry.id.level == patches.finest())
        own_error = std::max(own_error, static_cast<double>(entry.geometric_error_m));
  }
  while (plan.finest_ > 0 && own_error > kShareOfPack * assumed_error_m(plan.finest_, patches.ellipsoid()))
    --plan.finest_;
  if (options.max_error_m && *options.max_error_m <= own_error / kShareOfPack)
    return usage_error(
        fmt::format("largest error: expected more than {:g} m, since the pack itself is up to {:g} m off its "
                    "sources, found {:g} m",
                    own_error / kShareOfPack, own_error, *options.max_error_m));
  plan.choose_height_steps(options);
  return plan;
}

void QuantizedMeshPlan::choose_height_steps(const Options& options) {
  height_steps_.assign(static_cast<std::size_t>(finest_) + 1, 0);
  std::vector<double> widest(height_steps_.size(), 0);
  for (const Unit& unit : units()) {
    double& range_m = widest[static_cast<std::size_t>(unit.level)];
    for (const GeographicTile& tile : tiles_of(unit)) {
      const PackPatches::Range range = patches_->range_over(tile.rect(), unit.level - interval_bits_ - 2);
      const double low = range.complete ? range.lowest_m : std::min(range.lowest_m, 0.0);
      const double high = range.complete ? range.highest_m : std::max(range.highest_m, 0.0);
      range_m = std::max(range_m, high - low + 2 * range.error_m);
    }
  }
  for (int level = 0; level <= finest_; ++level) {
    const auto i = static_cast<std::size_t>(level);
    // No geoid is steeper than 7e-4 over a tile's 2·10^7 m / 2^L.
    if (options.shifted) widest[i] += std::min(220.0, std::ldexp(14000.0, -level));
    const double bound = std::min(assumed_error_m(level, patches_->ellipsoid()),
                                  max_error_m_.value_or(assumed_error_m(0, patches_->ellipsoid())));
    double step = std::exp2(std::floor(std::log2(bound / 32)));
    while (step * (kSteps - 2) < widest[i]) step *= 2;
    height_steps_[i] = step;
  }
}

bool QuantizedMeshPlan::has_data(const TickRect& rect, int level) const {
  if (regions_.empty()) return patches_->has_tile(rect, level);
  return std::any_of(regions_.begin(), regions_.end(), [&](const TickRect& region) {
    const TickRect both = intersection(rect, region);
    return both.width() > 0 && both.height() > 0 && patches_->has_tile(both, level);
  });
}

bool QuantizedMeshPlan::has(const GeographicTile& tile) const {
  if (tile.level == 0) return true;
  if (tile.level > finest_) return false;
  const GeographicTile parent{tile.level - 1, tile.x / 2, tile.y / 2};
  return has_data(parent.rect(), tile.level - interval_bits_ - 2);
}

std::vector<std::vector<TileRange>> QuantizedMeshPlan::below(const GeographicTile& tile, int levels) const {
  std::vector<TileRanges> sets(static_cast<std::size_t>(levels));
  const auto enter = [&](const auto& self, const GeographicTile& parent) -> void {
    const GeographicTile first{parent.level + 1, 2 * parent.x, 2 * parent.y};
    if (first.level > tile.level + levels || !has(first)) return;
    for (int q = 0; q < 4; ++q) {
      const GeographicTile child{first.level, first.x + (q & 1), first.y + (q >> 1)};
      sets[static_cast<std::size_t>(child.level - tile.level - 1)].add(child.x, child.y);
      self(self, child);
    }
  };
  enter(enter, tile);
  std::vector<std::vector<TileRange>> out;
  for (const TileRanges& set : sets) {
    out.push_back(set.rectangles());
    if (out.back().empty()) {
      out.pop_back();
      break;
    }
  }
  return out;
}

double QuantizedMeshPlan::bound_m(const GeographicTile& tile) const {
  const double assumed = assumed_error_m(tile.level, patches_->ellipsoid());
  const bool may_be_close = max_error_m_ && tile.level >= kLeastCloseLevel;
  if (!may_be_close || has({tile.level + 1, 2 * tile.x, 2 * tile.y})) return assumed;
  if (!has_data(tile.rect(), patches_->coarsest())) return assumed;
  return std::min(assumed, *max_error_m_);
}

void QuantizedMeshPlan::add_units(const GeographicTile& tile, int level, int block,
                                  std::vector<Unit>& out) const {
  if (!has(tile)) return;
  if (level - tile.level == block) {
    out.push_back({level, tile.x << block, tile.y << block, 1 << block});
    return;
  }
  for (int q = 0; q < 4; ++q)
    add_units({tile.level + 1, 2 * tile.x + (q & 1), 2 * tile.y + (q >> 1)}, level, block, out);
}

std::vector<QuantizedMeshPlan::Unit> QuantizedMeshPlan::units() const {
  std::vector<Unit> out;
  for (int level = 0; level <= finest_; ++level) {
    const int block = std::clamp(level - 6, 0, 3);
    for (const std::int64_t root : {0, 1}) add_units({0, root, 0}, level, block, out);
  }
  return out;
}

std::vector<GeographicTile> QuantizedMeshPlan::tiles_of(const Unit& unit) const {
  std::vector<GeographicTile> out;
  for (int j = 0; j < unit.side; ++j)
    for (int i = 0; i < unit.side; ++i)
      if (const GeographicTile tile{unit.level, unit.x + i, unit.y + j}; has(tile)) out.push_back(tile);
  return out;
}

}  // namespace cairn
