#include "builder/mosaic/mosaic.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "builder/mosaic/fade_weight.h"
#include "builder/mosaic/source_grouping.h"
#include "builder/mosaic/upsample.h"

namespace cairn {
namespace {

constexpr double kTouch = 1e-8;  // degrees: a footprint that ends on a tile's edge touches it

GeoBounds bounds_of(const SampleWindow& w) {
  return {w.lon_of(0), w.lat_of(0), w.lon_of(w.columns - 1), w.lat_of(w.rows - 1)};
}

template <class Loses>
void drop_posts(MeasuredPosts& posts, const SampleWindow& window, const Loses& loses) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  const auto lost = [&](double x, double y) {
    const LonLat place{(static_cast<double>(window.column) + x) / window.samples_per_degree - 180.0,
                       (static_cast<double>(window.row) + y) / window.samples_per_degree - 90.0};
    return loses(place);
  };
  for (std::size_t r = 0; r < posts.ys.size(); ++r) {
    for (std::size_t c = 0; c < posts.xs.size(); ++c) {
      if (lost(posts.xs[c], posts.ys[r])) posts.heights[r * posts.xs.size() + c] = kNone;
    }
  }
  std::erase_if(posts.placed, [&](const MeasuredPosts::Placed& p) { return lost(p.x, p.y); });
}

}  // namespace

Result<std::unique_ptr<Mosaic>> Mosaic::open(const MosaicOptions& options, int tile_size,
                                             std::size_t cache_bytes) {
  std::unique_ptr<Mosaic> mosaic(new Mosaic);
  mosaic->tile_size_ = tile_size;
  OpenOptions open_options;
  open_options.cache_bytes = cache_bytes;
  auto pool = RasterPool::open(options.inputs, open_options);
  if (!pool) return pool.error();
  mosaic->pool_ = std::move(*pool);
  if (options.geoid) {
    auto geoid = Geoid::open(*options.geoid);
    if (!geoid) return geoid.error();
    mosaic->geoid_ = std::move(*geoid);
  }
  auto groups =
      group_sources(*mosaic->pool_, mosaic->geoid_ ? &*mosaic->geoid_ : nullptr, options, tile_size);
  if (!groups) return groups.error();
  mosaic->groups_ = std::move(*groups);
  mosaic->set_reaches();
  for (std::size_t s = 0; s < mosaic->pool_->size(); ++s) {
    mosaic->whole_metres_ = mosaic->whole_metres_ && mosaic->pool_->info(s).whole_metres;
  }
  return mosaic;
}

// A group fades over one post of the coarsest group that it lies upon, or beside.
void Mosaic::set_reaches() {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    Reach reach{groups_[g]->spacing_degrees(), 0};
    for (std::size_t below = g + 1; below < groups_.size(); ++below) {
      const double spacing = groups_[below]->spacing_degrees();
      const auto& rectangles = groups_[below]->footprint().rectangles();
      const bool beneath = std::any_of(rectangles.begin(), rectangles.end(), [&](const GeoBounds& r) {
        return groups_[g]->footprint().overlaps(r, reach.solid + spacing);
      });
      if (beneath) reach.fade = std::max(reach.fade, spacing);
    }
    groups_[g]->set_reach(reach.solid, reach.fade);
    reaches_.push_back(reach);
  }
}

int Mosaic::finest_level() const {
  int finest = kMinLevel;
  for (const auto& group : groups_) finest = std::max(finest, group->native_level());
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

double Mosaic::samples_per_post() const {
  double least = std::numeric_limits<double>::infinity();
  for (const auto& group : groups_) least = std::min(least, group->samples_per_post());
  return least;
}

void Mosaic::set_tolerance(const SmoothTolerance& tolerance) {
  for (const auto& group : groups_) group->set_tolerance(tolerance);
}

bool Mosaic::posts_are_samples() const {
  return !geoid_ && groups_.size() == 1 && groups_.front()->posts_on_samples();
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

std::vector<std::size_t> Mosaic::groups_touching(const GeoBounds& bounds) const {
  std::vector<std::size_t> touching;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const double reach = reaches_[g].fade > 0 ? reaches_[g].solid + reaches_[g].fade : kTouch;
    if (!groups_[g]->footprint().overlaps(bounds, reach)) continue;
    touching.push_back(g);
  }
  return touching;
}

std::optional<int> Mosaic::leaf_level(const TileId& id) const {
  if (!covers(id)) return std::nullopt;
  int finest = kMinLevel;
  for (const std::size_t g : groups_touching(without_overhang(tile_bounds(id))))
    finest = std::max(finest, groups_[g]->native_level());
  return finest;
}

double Mosaic::weight(std::size_t group, const Footprint& near, LonLat place) const {
  return fade_weight(near.distance_to(place) - reaches_[group].solid, reaches_[group].fade);
}

// Lays the group's samples over what the tile has so far.
void Mosaic::blend(std::size_t group, const SampleWindow& window, GroupSamples&& samples,
                   MosaicTile& tile) const {
  const Footprint near =
      groups_[group]->footprint().near(bounds_of(window), reaches_[group].solid + reaches_[group].fade);
  const bool fades_in_voids = !samples.fill_weights.empty();
  std::size_t at = 0;
  for (int r = 0; r < window.rows; ++r) {
    for (int c = 0; c < window.columns; ++c, ++at) {
      const SampleState above = samples.states.empty() ? SampleState::sourced : samples.states[at];
      const bool ends_here = above == SampleState::none && !groups_[group]->reaches_beyond_footprint();
      double w = ends_here ? 0 : weight(group, near, {window.lon_of(c), window.lat_of(r)});
      if (above == SampleState::filled && fades_in_voids)
        w = std::min(w, static_cast<double>(samples.fill_weights[at]));
      if (tile.states[at] == SampleState::none) {
        tile.heights[at] = samples.heights[at];
        tile.states[at] = above;
      } else if (w > 0 && !std::isnan(samples.heights[at])) {
        tile.heights[at] = static_cast<float>(w * static_cast<double>(samples.heights[at]) +
                                              (1 - w) * static_cast<double>(tile.heights[at]));
        if (w == 1 && above != SampleState::none)
          tile.states[at] = fades_in_voids ? std::max(above, tile.states[at]) : above;
      }
    }
  }
}

void Mosaic::drop_losing_posts(const SampleWindow& window, std::span<const std::size_t> touching,
                               MosaicTile& tile) const {
  for (std::size_t below = 0; below < touching.size(); ++below) {
    const double margin = groups_[touching[below]]->spacing_degrees();
    std::vector<std::pair<Footprint, double>> above;
    for (std::size_t k = 0; k < below; ++k) {
      const double reach = reaches_[touching[k]].solid + reaches_[touching[k]].fade + margin;
      above.emplace_back(groups_[touching[k]]->footprint().near(bounds_of(window), reach), reach);
    }
    drop_posts(tile.posts[below], window, [&](LonLat place) {
      return std::any_of(above.begin(), above.end(),
                         [&](const auto& a) { return a.first.distance_to(place) <= a.second; });
    });
  }
}

// The samples of the groups that show in the window, from the top: nothing shows beneath one that has a value
// everywhere.
Result<std::vector<Mosaic::GroupLayer>> Mosaic::sample_layers(const SampleWindow& window, int level) const {
  std::vector<GroupLayer> layers;
  for (const std::size_t g : groups_touching(without_overhang(bounds_of(window)))) {
    const int levels = level - groups_[g]->native_level();
    assert(levels >= 0);
    auto samples = groups_[g]->sample(coarser_window(window, levels));
    if (!samples) return samples.error();
    if (levels > 0) *samples = upsample(*samples, window, levels);
    layers.push_back({g, std::move(*samples)});
    const auto& states = layers.back().samples.states;
    const bool complete =
        std::all_of(states.begin(), states.end(), [](SampleState s) { return s == SampleState::sourced; });
    if (complete && groups_[g]->footprint().contains(bounds_of(window))) break;
  }
  return layers;
}

Result<MosaicTile> Mosaic::sample_window(const SampleWindow& window, int level) const {
  auto layers = sample_layers(window, level);
  if (!layers) return layers.error();
  MosaicTile tile;
  for (GroupLayer& layer : *layers) {
    tile.groups.push_back(layer.group);
    tile.posts.push_back(std::move(layer.samples.posts));
  }
  if (layers->size() == 1) {
    tile.heights = std::move(layers->front().samples.heights);
    tile.states = std::move(layers->front().samples.states);
    return tile;
  }
  tile.heights.assign(window.count(), std::numeric_limits<float>::quiet_NaN());
  tile.states.assign(window.count(), SampleState::none);
  for (std::size_t k = layers->size(); k-- > 0;)
    blend((*layers)[k].group, window, std::move((*layers)[k].samples), tile);
  drop_losing_posts(window, tile.groups, tile);
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

}  // namespace cairn
