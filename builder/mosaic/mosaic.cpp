#include "builder/mosaic/mosaic.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "builder/mosaic/companions.h"
#include "builder/mosaic/lattice.h"
#include "builder/mosaic/source_grouping.h"

namespace cairn {
namespace {

constexpr std::size_t kFirstCacheBytes = std::size_t{8} << 20;  // while little is read
constexpr std::size_t kMostBlockBytes = std::size_t{24} << 20;
constexpr double kTouch = 1e-8;  // degrees: a footprint that ends on a tile's edge touches it

GeoBounds bounds_of(const SampleWindow& w) {
  return {w.lon_of(0), w.lat_of(0), w.lon_of(w.columns - 1), w.lat_of(w.rows - 1)};
}

// How near a fit at the border of two groups comes to what it aims at, as a share of the error bound.
constexpr double kTolerance = 0.1;

}  // namespace

Result<std::unique_ptr<Mosaic>> Mosaic::open(const MosaicOptions& options, int tile_size) {
  OpenOptions open_options;
  open_options.cache_bytes = kFirstCacheBytes;
  open_options.rules = options.source_rules;
  auto pool = RasterPool::open(options.inputs, open_options, RasterPool::Content::heights);
  if (!pool) return pool.error();
  if (auto dems = refuse_companions(**pool); !dems) return dems.error();
  return over(std::move(*pool), options, tile_size, true);
}

Result<std::unique_ptr<Mosaic>> Mosaic::over(std::unique_ptr<RasterPool> pool, const MosaicOptions& options,
                                             int tile_size, bool open_geoid) {
  std::unique_ptr<Mosaic> mosaic(new Mosaic);
  mosaic->tile_size_ = tile_size;
  mosaic->pool_ = std::move(pool);
  auto datum = vertical_datum_of(*mosaic->pool_, options.datum, options.geoid.has_value());
  if (!datum) return datum.error();
  mosaic->datum_ = std::move(*datum);
  mosaic->with_geoid_ = options.geoid.has_value();
  if (options.geoid && open_geoid) {
    auto geoid = Geoid::open(*options.geoid);
    if (!geoid) return geoid.error();
    mosaic->geoid_ = std::move(*geoid);
  }
  auto groups = group_sources(*mosaic->pool_, mosaic->geoid_ ? &*mosaic->geoid_ : nullptr, options, tile_size,
                              mosaic->blocks_);
  if (!groups) return groups.error();
  mosaic->groups_ = std::move(*groups);
  for (const auto& group : mosaic->groups_) {
    if (options.void_posts) group->set_void_distance(*options.void_posts);
    mosaic->whole_metres_.push_back(
        std::all_of(group->sources().begin(), group->sources().end(),
                    [&](std::size_t s) { return mosaic->pool_->info(s).whole_metres; }));
  }
  mosaic->asked_error_bound_m_ = options.max_error_m;
  mosaic->overlay_groups(options);
  return mosaic;
}

void Mosaic::set_cache_bytes(std::size_t bytes) {
  const std::size_t of_blocks = has_projected_sources() ? std::min(bytes / 8, kMostBlockBytes) : 0;
  blocks_->set_byte_limit(of_blocks);
  pool_->set_cache_bytes(bytes - of_blocks);
}

bool Mosaic::has_projected_sources() const {
  for (std::size_t s = 0; s < pool_->size(); ++s)
    if (!place_on_lattice(pool_->info(s))) return true;
  return false;
}

// A group fades over posts of the coarsest group that it lies upon, and is overlaid on samples no coarser
// than those of any that it meets.
void Mosaic::overlay_groups(const MosaicOptions& options) {
  std::vector<GroupOverlay::Layer> layers(groups_.size());
  for (std::size_t g = groups_.size(); g-- > 0;) {
    GroupOverlay::Layer& layer = layers[g];
    layer.group = groups_[g].get();
    layer.level = groups_[g]->native_level();
    bool lies_upon_any = false;
    for (std::size_t below = g + 1; below < groups_.size(); ++below) {
      const double spacing = groups_[below]->spacing_degrees();
      const double fade = options.fade_posts * spacing;
      const auto& rectangles = groups_[below]->footprint().rectangles();
      const auto within = [&](double margin) {
        return std::any_of(rectangles.begin(), rectangles.end(),
                           [&](const GeoBounds& r) { return groups_[g]->comes_within(r, margin); });
      };
      if (within(0)) {
        lies_upon_any = true;
        layer.fade_degrees = std::max(layer.fade_degrees, fade);
      }
      // So near that one tile, with what is looked at around it, can need both.
      const double beside = 2 * tile_width_degrees(groups_[g]->native_level());
      if (within(layers[below].margin() + fade + beside))
        layer.level = std::max(layer.level, layers[below].level);
    }
    layer.samples_per_degree = static_cast<double>(tile_size_ - 1) / tile_width_degrees(layer.level);
    // Where something lies beneath, a void shows it, if only after a step.
    constexpr double kStep = 1e-9;
    groups_[g]->set_reach(groups_[g]->spacing_degrees(),
                          lies_upon_any ? std::max(layer.fade_degrees, kStep) : 0);
  }
  const double bound = error_bounds().least_m;
  overlay_.emplace(std::move(layers), kTolerance * bound);
}

int Mosaic::finest_level() const {
  int finest = kMinLevel;
  for (const GroupOverlay::Layer& layer : overlay_->layers()) finest = std::max(finest, layer.level);
  return finest;
}

GeoBounds Mosaic::bounds() const {
  Footprint all;
  for (const auto& group : groups_) all.add(group->footprint().bounds());
  return all.bounds();
}

bool Mosaic::is_global() const {
  return std::any_of(groups_.begin(), groups_.end(), [](const auto& group) {
    const GeoBounds b = group->footprint().bounds();
    return b.width() >= 360.0 - group->spacing_degrees() &&
           b.height() >= 180.0 - 2 * group->spacing_degrees();
  });
}

double Mosaic::error_bound_m(std::size_t group) const {
  return asked_error_bound_m_.value_or(whole_metres_[group] ? 0.5 : 0.05);
}

Mosaic::ErrorBounds Mosaic::error_bounds() const {
  ErrorBounds bounds{error_bound_m(0), error_bound_m(0)};
  for (std::size_t g = 1; g < groups_.size(); ++g) {
    bounds.least_m = std::min(bounds.least_m, error_bound_m(g));
    bounds.largest_m = std::max(bounds.largest_m, error_bound_m(g));
  }
  return bounds;
}

void Mosaic::set_tolerance(std::size_t group, const SmoothTolerance& tolerance) {
  groups_[group]->set_tolerance(tolerance);
}

bool Mosaic::posts_are_samples() const {
  return !with_geoid_ && groups_.size() == 1 && groups_.front()->posts_on_samples();
}

bool Mosaic::covers(const TileId& id) const {
  const GeoBounds bounds = without_overhang(tile_bounds(id));
  return std::any_of(groups_.begin(), groups_.end(),
                     [&](const auto& g) { return g->footprint().overlaps(bounds); });
}

bool Mosaic::touches(const TileId& id) const {
  const GeoBounds bounds = without_overhang(tile_bounds(id));
  return std::any_of(groups_.begin(), groups_.end(),
                     [&](const auto& g) { return g->footprint().overlaps(bounds, kTouch); });
}

int Mosaic::finest_level_of(std::span<const std::size_t> groups) const {
  int finest = kMinLevel;
  for (const std::size_t g : groups) finest = std::max(finest, overlay_->layers()[g].level);
  return finest;
}

std::optional<int> Mosaic::leaf_level(const TileId& id) const {
  if (!covers(id)) return std::nullopt;
  return finest_level_of(overlay_->reaching(without_overhang(tile_bounds(id))));
}

Result<MosaicTile> Mosaic::sample_window(const SampleWindow& window, int level) const {
  MosaicTile tile;
  tile.groups = overlay_->needed(without_overhang(bounds_of(window)), level);
  if (tile.groups.empty()) {  // beyond the end of all
    tile.heights.assign(window.count(), std::numeric_limits<float>::quiet_NaN());
    tile.states.assign(window.count(), SampleState::none);
    return tile;
  }
  auto samples = overlay_->sample(tile.groups, window, level);
  if (!samples) return samples.error();
  tile.heights = std::move(samples->heights);
  tile.states = std::move(samples->states);
  tile.posts = std::move(samples->posts);
  const bool complete = std::all_of(tile.states.begin(), tile.states.end(),
                                    [](SampleState s) { return s == SampleState::sourced; });
  if (complete) tile.states.clear();
  return tile;
}

Result<MosaicTile> Mosaic::sample(const TileId& id) const {
  const SampleWindow window = window_of(id, tile_size_);
  auto tile = sample_window(window, id.level);
  if (!tile) return tile;
  // 180°E is 180°W: the same bits. Farther east and north of the pole the tile overhangs the world.
  const std::int64_t antimeridian = std::llround(360.0 * window.samples_per_degree) - window.column;
  const std::int64_t pole = std::llround(180.0 * window.samples_per_degree) - window.row;
  if (antimeridian >= window.columns && pole >= window.rows - 1) return tile;
  if (tile->states.empty()) tile->states.assign(window.count(), SampleState::sourced);
  if (antimeridian < window.columns) {
    SampleWindow line = window;
    line.column = 0;
    line.columns = 2;  // a line alone would cover no area
    auto west = sample_window(line, id.level);
    if (!west) return west;
    for (std::size_t r = 0; r < static_cast<std::size_t>(window.rows); ++r) {
      const std::size_t at =
          r * static_cast<std::size_t>(window.columns) + static_cast<std::size_t>(antimeridian);
      tile->heights[at] = west->heights[2 * r];
      tile->states[at] = west->states.empty() ? SampleState::sourced : west->states[2 * r];
    }
  }
  for (std::int64_t r = 0; r < window.rows; ++r) {
    for (std::int64_t c = 0; c < window.columns; ++c) {
      if (c > antimeridian || r > pole)
        tile->states[static_cast<std::size_t>(r * window.columns + c)] = SampleState::none;
    }
  }
  return tile;
}

// At a pole all samples of the row are one place.
std::vector<std::uint8_t> Mosaic::near_fractions(const TileId& id) const {
  const SampleWindow window = window_of(id, tile_size_);
  const GeoBounds bounds = bounds_of(window);
  std::vector<std::uint8_t> near;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    if (whole_metres_[g]) continue;
    const double reach = overlay_->layers()[g].reach();
    const Footprint around = groups_[g]->footprint().near(bounds, reach + kTouch);
    if (around.rectangles().empty()) continue;
    near.resize(window.count());
    std::size_t at = 0;
    for (int r = 0; r < window.rows; ++r) {
      const bool at_pole = std::abs(window.lat_of(r)) >= 90;
      for (int c = 0; c < window.columns; ++c, ++at) {
        if (near[at] != 0) continue;
        const bool reached = around.distance_to({window.lon_of(c), window.lat_of(r)}) <= reach;
        near[at] = at_pole || reached ? 1 : 0;
      }
    }
  }
  return near;
}

}  // namespace cairn
