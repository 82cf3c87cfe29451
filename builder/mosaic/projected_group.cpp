#include "builder/mosaic/projected_group.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace cairn {
namespace {

constexpr std::size_t kCachedBlocks = 16;
constexpr std::int64_t kNeverWraps = std::int64_t{1} << 40;
constexpr float kNoHeight = std::numeric_limits<float>::quiet_NaN();

IndexWindow extent_of(const RasterInfo& info) {
  return {{0, info.columns - 1}, {0, info.rows - 1}};
}

IndexWindow grown(const SampleWindow& w, std::int64_t by) {
  return {{w.column - by, w.column + w.columns - 1 + by}, {w.row - by, w.row + w.rows - 1 + by}};
}

std::int64_t floor_divide(std::int64_t a, std::int64_t b) {
  return a >= 0 ? a / b : -((-a + b - 1) / b);
}

double samples_per_degree_at(int level, int tile_size) {
  return static_cast<double>(tile_size - 1) / tile_width_degrees(level);
}

}  // namespace

int ProjectedGroup::level_for(const RasterInfo& info, int tile_size) {
  int level = kMinLevel;
  while (level < kMaxLevel && !ProjectedResampler(info.georeference, samples_per_degree_at(level, tile_size))
                                   .is_well_conditioned(extent_of(info))) {
    ++level;
  }
  return level;
}

ProjectedGroup::ProjectedGroup(RasterPool& pool, const Geoid* geoid, std::size_t source, int native_level,
                               int tile_size, double tolerance_m)
    : pool_(pool),
      geoid_(geoid),
      info_(pool.info(source)),
      extent_(extent_of(info_)),
      intervals_(tile_size - 1),
      samples_per_degree_(samples_per_degree_at(native_level, tile_size)),
      tolerance_m_(tolerance_m),
      resampler_(info_.georeference, samples_per_degree_),
      fill_({extent_}, kNeverWraps,
            [this](IndexRange columns, IndexRange rows) { return read_posts(columns, rows); }) {
  native_level_ = native_level;
  spacing_degrees_ = 1.0 / posts_per_degree(info_.georeference, extent_);
  reaches_beyond_footprint_ = false;
  footprint_.add(info_.bounds);
  sources_ = {source};
}

// Posts by column and by row in the file's order.
Result<PostBlock> ProjectedGroup::read_posts(IndexRange columns, IndexRange rows) const {
  PostBlock block{
      columns.first, rows.first, static_cast<int>(columns.count()), static_cast<int>(rows.count()), {}, {}};
  const std::size_t count = static_cast<std::size_t>(block.columns) * static_cast<std::size_t>(block.rows);
  block.heights.assign(count, kNoHeight);
  block.owners.assign(count, PostBlock::kOutside);
  const IndexRange x{std::max(columns.first, extent_.x.first), std::min(columns.last, extent_.x.last)};
  const IndexRange y{std::max(rows.first, extent_.y.first), std::min(rows.last, extent_.y.last)};
  if (x.count() <= 0 || y.count() <= 0) return block;

  const auto source = pool_.acquire(sources_.front());
  if (!source) return source.error();
  std::vector<float> read(static_cast<std::size_t>(x.count() * y.count()));
  if (auto status = (*source)->read_heights({x.first, y.first, x.count(), y.count()}, read); !status)
    return status.error();
  std::size_t from = 0;
  for (std::int64_t r = y.first; r <= y.last; ++r) {
    for (std::int64_t c = x.first; c <= x.last; ++c, ++from) {
      const std::size_t to =
          block.index(static_cast<int>(c - columns.first), static_cast<int>(r - rows.first));
      block.owners[to] = std::isnan(read[from]) ? PostBlock::kVoid : 1;
      block.heights[to] = read[from];
      if (geoid_ == nullptr) continue;
      const LonLat place = info_.georeference.place_of(static_cast<double>(c), static_cast<double>(r));
      block.heights[to] += static_cast<float>(geoid_->undulation(place));
    }
  }
  return block;
}

std::vector<SampleState> ProjectedGroup::states_of(const SampleWindow& window, const PostBlock& posts) const {
  const auto state_at = [&](double column, double row) {
    SampleState best = SampleState::none;
    const auto last_r = static_cast<std::int64_t>(std::ceil(row));
    const auto last_c = static_cast<std::int64_t>(std::ceil(column));
    for (auto r = static_cast<std::int64_t>(std::floor(row)); r <= last_r; ++r) {
      for (auto c = static_cast<std::int64_t>(std::floor(column)); c <= last_c; ++c) {
        if (c < posts.i0 || r < posts.j0 || c >= posts.i0 + posts.columns || r >= posts.j0 + posts.rows)
          continue;
        const std::uint16_t owner =
            posts.owners[posts.index(static_cast<int>(c - posts.i0), static_cast<int>(r - posts.j0))];
        if (PostBlock::has_value(owner)) return SampleState::sourced;
        if (owner == PostBlock::kVoid) best = SampleState::filled;
      }
    }
    return best;
  };
  std::vector<SampleState> states;
  states.reserve(window.count());
  for (int r = 0; r < window.rows; ++r) {
    for (int c = 0; c < window.columns; ++c) {
      const auto post = info_.georeference.post_at({window.lon_of(c), window.lat_of(r)});
      states.push_back(state_at(post.column, post.row));
    }
  }
  return states;
}

// A window without any post of the raster has no samples; one that has some is fitted.
Result<ProjectedGroup::BlockPointer> ProjectedGroup::make_block(std::int64_t x, std::int64_t y) const {
  auto block = std::make_shared<Block>();
  block->window = {x * intervals_, y * intervals_, intervals_, intervals_, samples_per_degree_};
  const IndexWindow samples = grown(block->window, ProjectedResampler::kHalo);
  const IndexWindow wanted = resampler_.posts_for(samples);
  auto posts = read_posts(wanted.x, wanted.y);
  if (!posts) return posts.error();
  const bool complete = std::all_of(posts->owners.begin(), posts->owners.end(), PostBlock::has_value);
  if (!complete) {
    block->states = states_of(block->window, *posts);
    if (auto status = fill_.complete(*posts); !status) return status.error();
  }
  std::vector<float> out(static_cast<std::size_t>(samples.count()));
  resampler_.resample(posts->heights, samples, tolerance_m_, out);
  block->heights.reserve(block->window.count());
  for (std::int64_t r = 0; r < intervals_; ++r) {
    const auto row = out.begin() +
                     static_cast<std::ptrdiff_t>(samples.offset(block->window.column, block->window.row + r));
    block->heights.insert(block->heights.end(), row, row + intervals_);
  }
  return BlockPointer(std::move(block));
}

// Two threads that miss the same block both make it: the same bits, and neither waits.
Result<ProjectedGroup::BlockPointer> ProjectedGroup::block_at(std::int64_t x, std::int64_t y) const {
  {
    const std::scoped_lock lock(mutex_);
    const auto found =
        std::find_if(cache_.begin(), cache_.end(), [&](const Cached& c) { return c.x == x && c.y == y; });
    if (found != cache_.end()) {
      cache_.splice(cache_.begin(), cache_, found);
      return cache_.front().block;
    }
  }
  auto block = make_block(x, y);
  if (!block) return block;
  const std::scoped_lock lock(mutex_);
  cache_.push_front({x, y, *block});
  if (cache_.size() > kCachedBlocks) cache_.pop_back();
  return block;
}

// Puts the posts in the closed window at their places, by the projection itself: not as the fit saw them.
Status ProjectedGroup::add_posts(const SampleWindow& window, MeasuredPosts& posts) const {
  const IndexWindow wanted = resampler_.posts_for(grown(window, 0));
  const IndexRange x{std::max(wanted.x.first, extent_.x.first), std::min(wanted.x.last, extent_.x.last)};
  const IndexRange y{std::max(wanted.y.first, extent_.y.first), std::min(wanted.y.last, extent_.y.last)};
  if (x.count() <= 0 || y.count() <= 0) return {};
  const auto read = read_posts(x, y);
  if (!read) return read.error();
  for (std::int64_t r = y.first; r <= y.last; ++r) {
    for (std::int64_t c = x.first; c <= x.last; ++c) {
      const std::size_t at = read->index(static_cast<int>(c - x.first), static_cast<int>(r - y.first));
      if (!PostBlock::has_value(read->owners[at])) continue;
      const LonLat place = info_.georeference.place_of(static_cast<double>(c), static_cast<double>(r));
      const double px = (place.lon + 180.0) * samples_per_degree_ - static_cast<double>(window.column);
      const double py = (place.lat + 90.0) * samples_per_degree_ - static_cast<double>(window.row);
      if (px < 0 || py < 0 || px > window.columns - 1 || py > window.rows - 1) continue;
      posts.placed.push_back({px, py, read->heights[at], read->owners[at]});
    }
  }
  return {};
}

Result<GroupSamples> ProjectedGroup::sample(const SampleWindow& window) const {
  assert(window.samples_per_degree == samples_per_degree_);
  GroupSamples samples;
  samples.heights.resize(window.count());
  samples.states.assign(window.count(), SampleState::sourced);
  const std::int64_t east = window.column + window.columns;
  const std::int64_t north = window.row + window.rows;
  for (std::int64_t by = floor_divide(window.row, intervals_); by * intervals_ < north; ++by) {
    for (std::int64_t bx = floor_divide(window.column, intervals_); bx * intervals_ < east; ++bx) {
      const auto block = block_at(bx, by);
      if (!block) return block.error();
      const SampleWindow& b = (*block)->window;
      for (std::int64_t r = std::max(window.row, b.row); r < std::min(north, b.row + b.rows); ++r) {
        for (std::int64_t c = std::max(window.column, b.column); c < std::min(east, b.column + b.columns);
             ++c) {
          const auto from = static_cast<std::size_t>((r - b.row) * b.columns + (c - b.column));
          const auto to = static_cast<std::size_t>((r - window.row) * window.columns + (c - window.column));
          samples.heights[to] = (*block)->heights[from];
          if (!(*block)->states.empty()) samples.states[to] = (*block)->states[from];
        }
      }
    }
  }
  if (auto status = add_posts(window, samples.posts); !status) return status.error();
  return samples;
}

}  // namespace cairn
