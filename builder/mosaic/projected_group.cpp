#include "builder/mosaic/projected_group.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include "builder/mosaic/fade_weight.h"
#include "builder/mosaic/fill_in_posts.h"
#include "builder/mosaic/void_end.h"
#include "builder/raster/raster_placement.h"
#include "builder/voids/void_distance.h"

namespace cairn {
namespace {

constexpr std::int64_t kNeverWraps = std::int64_t{1} << 40;
constexpr float kNoHeight = std::numeric_limits<float>::quiet_NaN();

std::vector<IndexWindow> extents_of(const RasterPool& pool, const ProjectedGroup::Grid& grid) {
  std::vector<IndexWindow> extents;
  for (const auto& m : grid.members) {
    const RasterInfo& info = pool.info(m.source);
    extents.push_back({{m.placement.column, m.placement.column + info.columns - 1},
                       {m.placement.row, m.placement.row + info.rows - 1}});
  }
  return extents;
}

IndexWindow grown(const SampleWindow& w, std::int64_t by) {
  return {{w.column - by, w.column + w.columns - 1 + by}, {w.row - by, w.row + w.rows - 1 + by}};
}

double samples_per_degree_at(int level, int tile_size) {
  return static_cast<double>(tile_size - 1) / tile_width_degrees(level);
}

SampleState state_of(std::uint16_t owner) {
  if (PostBlock::has_value(owner)) return SampleState::sourced;
  return owner == PostBlock::kVoid ? SampleState::filled : SampleState::none;
}

// The best of the posts around a position.
SampleState state_at(const PlanePoint& position, const PostBlock& posts) {
  if (std::isnan(position.x)) return SampleState::none;
  const auto c0 = static_cast<int>(static_cast<std::int64_t>(std::floor(position.x)) - posts.i0);
  const auto c1 = static_cast<int>(static_cast<std::int64_t>(std::ceil(position.x)) - posts.i0);
  const auto r0 = static_cast<int>(static_cast<std::int64_t>(std::floor(position.y)) - posts.j0);
  const auto r1 = static_cast<int>(static_cast<std::int64_t>(std::ceil(position.y)) - posts.j0);
  return std::max({state_of(posts.owners[posts.index(c0, r0)]), state_of(posts.owners[posts.index(c1, r0)]),
                   state_of(posts.owners[posts.index(c0, r1)]), state_of(posts.owners[posts.index(c1, r1)])});
}

bool has_filled(const SampleState* states, std::size_t count) {
  return states != nullptr && std::find(states, states + count, SampleState::filled) != states + count;
}

}  // namespace

int ProjectedGroup::level_for(const RasterPool& pool, const Grid& grid, int tile_size) {
  const IndexWindow hull = WindowIndex(extents_of(pool, grid)).hull();
  const double least = 1.03 * posts_per_degree(grid.georeference, hull);
  int level = kMinLevel;
  while (level < kMaxLevel && samples_per_degree_at(level, tile_size) < least) ++level;
  return level;
}

ProjectedGroup::ProjectedGroup(RasterPool& pool, const Geoid* geoid, Grid grid, int native_level,
                               int tile_size, ResampleMethod method, double tolerance_m,
                               std::shared_ptr<ChunkCache> blocks, std::uint64_t number)
    : pool_(pool),
      geoid_(geoid),
      grid_(std::move(grid)),
      members_(extents_of(pool, grid_)),
      block_side_((tile_size - 1) / 2),
      samples_per_degree_(samples_per_degree_at(native_level, tile_size)),
      method_(method),
      tolerance_m_(tolerance_m),
      resampler_(grid_.georeference, members_.hull(), samples_per_degree_),
      fill_(members_.extents(), kNeverWraps,
            [this](IndexRange columns, IndexRange rows) { return read_posts(columns, rows); }),
      blocks_(std::move(blocks)),
      number_(number) {
  assert(grid_.members.size() < PostBlock::kVoid - 1u);
  is_projected_ = true;
  native_level_ = native_level;
  spacing_degrees_ = 1.0 / posts_per_degree(grid_.georeference, members_.hull());
  const int halvings = grid_.members.size() == 1 ? 3 : grid_.members.size() < 64 ? 2 : 0;
  for (const Member& m : grid_.members) {
    for (GeoBounds part : tight_bounds(pool.info(m.source), halvings)) {
      move_near(pool.info(grid_.members.front().source).bounds, part);
      footprint_.add(part);
    }
    sources_.push_back(m.source);
    is_shifted_ = is_shifted_ || m.placement.is_shifted;
  }
}

// Copies the member's posts to where the block has no value yet.
Status ProjectedGroup::read_member(std::size_t member, PostBlock& block) const {
  const IndexWindow& extent = members_.extents()[member];
  const IndexRange x{std::max(block.i0, extent.x.first),
                     std::min(block.i0 + block.columns - 1, extent.x.last)};
  const IndexRange y{std::max(block.j0, extent.y.first), std::min(block.j0 + block.rows - 1, extent.y.last)};
  const auto width = static_cast<std::size_t>(x.count());
  const std::size_t count = width * static_cast<std::size_t>(y.count());
  const auto read = std::make_unique_for_overwrite<float[]>(count);
  const PostWindow window{x.first - extent.x.first, y.first - extent.y.first, x.count(), y.count()};
  if (auto status = pool_.read_heights(grid_.members[member].source, window, {read.get(), count}); !status)
    return status;
  for (std::int64_t r = y.first; r <= y.last; ++r) {
    const std::size_t to = block.index(static_cast<int>(x.first - block.i0), static_cast<int>(r - block.j0));
    fill_in_posts(read.get() + (r - y.first) * x.count(), width, static_cast<std::uint16_t>(member + 1),
                  block.heights.data() + to, block.owners.data() + to);
  }
  return {};
}

void ProjectedGroup::add_geoid(PostBlock& block) const {
  for (int r = 0; r < block.rows; ++r) {
    for (int c = 0; c < block.columns; ++c) {
      float& height = block.heights[block.index(c, r)];
      if (std::isnan(height)) continue;
      const LonLat place =
          grid_.georeference.place_of(static_cast<double>(block.i0 + c), static_cast<double>(block.j0 + r));
      height += static_cast<float>(geoid_->undulation(place));
    }
  }
}

// By how much each post lies off the grid's, in posts; empty where none does.
std::vector<PlanePoint> ProjectedGroup::shifts_of(const PostBlock& block) const {
  std::vector<PlanePoint> shifts;
  if (!is_shifted_) return shifts;
  shifts.resize(block.owners.size());
  for (int r = 0; r < block.rows; ++r) {
    for (int c = 0; c < block.columns; ++c) {
      const std::size_t at = block.index(c, r);
      if (!PostBlock::has_value(block.owners[at])) continue;
      const Member& member = grid_.members[block.owners[at] - 1u];
      const auto column = static_cast<double>(block.i0 + c), row = static_cast<double>(block.j0 + r);
      const LonLat own =
          pool_.info(member.source)
              .georeference.coordinate_of(column - static_cast<double>(member.placement.column),
                                          row - static_cast<double>(member.placement.row));
      const auto on_grid = grid_.georeference.post_at_coordinate(own);
      shifts[at] = {on_grid.column - column, on_grid.row - row};
    }
  }
  return shifts;
}

// Posts by column and by row in the grid's order.
Result<PostBlock> ProjectedGroup::read_posts(IndexRange columns, IndexRange rows) const {
  PostBlock block{
      columns.first, rows.first, static_cast<int>(columns.count()), static_cast<int>(rows.count()), {}, {}};
  const std::size_t count = static_cast<std::size_t>(block.columns) * static_cast<std::size_t>(block.rows);
  block.heights.assign(count, kNoHeight);
  block.owners.assign(count, PostBlock::kOutside);
  for (const std::size_t member : members_.overlapping({columns, rows})) {
    if (auto status = read_member(member, block); !status) return status.error();
  }
  if (geoid_ != nullptr) add_geoid(block);
  return block;
}

// A sample may be off by the tolerance of its own block's fit and by that of the neighbouring block's.
FitTolerance ProjectedGroup::fit_tolerance() const {
  const bool smooth = method_ == ResampleMethod::smooth;
  return {smooth ? std::max(0.0, tolerance_.interval_m - 2 * tolerance_m_) : 0, tolerance_m_};
}

SampleWindow ProjectedGroup::window_of_block(std::int64_t x, std::int64_t y) const {
  const auto side = static_cast<int>(block_side_);
  return {x * block_side_, y * block_side_, side, side, samples_per_degree_};
}

// The window's part of what was resampled around it. `met` is empty where all samples are sourced.
ChunkCache::Chunk ProjectedGroup::cut_out(const SampleWindow& window, const SamplePositions& positions,
                                          const PostBlock& posts, std::span<const float> heights,
                                          std::span<const std::uint8_t> met) const {
  const auto columns = static_cast<std::size_t>(window.columns);
  const std::size_t heights_end = window.count() * sizeof(float);
  ChunkCache::Chunk chunk = blocks_->room_for(heights_end + (met.empty() ? 0 : window.count()));
  std::byte* to = chunk.data();
  std::byte* state = to + heights_end;
  for (std::int64_t r = 0; r < window.rows; ++r, to += columns * sizeof(float)) {
    const std::size_t first = positions.samples.offset(window.column, window.row + r);
    std::memcpy(to, heights.data() + first, columns * sizeof(float));
    for (std::size_t i = first; !met.empty() && i < first + columns; ++i, ++state)
      *state = static_cast<std::byte>(met[i] != 0 ? SampleState::sourced : state_at(positions.at[i], posts));
  }
  return chunk;
}

// Nothing where there are no posts around the window.
Result<ChunkCache::Chunk> ProjectedGroup::make_block(const SampleWindow& window) const {
  const SamplePositions positions = resampler_.positions_of(grown(window, ProjectedResampler::kHalo));
  if (positions.posts.count() <= 0) return ChunkCache::Chunk();
  auto posts = read_posts(positions.posts.x, positions.posts.y);
  if (!posts) return posts.error();
  std::vector<std::uint8_t> fitted(posts->owners.size());
  std::transform(posts->owners.begin(), posts->owners.end(), fitted.begin(),
                 [](std::uint16_t owner) { return PostBlock::has_value(owner) ? 1 : 0; });
  const bool complete = std::find(fitted.begin(), fitted.end(), 0) == fitted.end();
  const bool any = std::any_of(posts->owners.begin(), posts->owners.end(),
                               [](std::uint16_t owner) { return owner != PostBlock::kOutside; });
  if (!any) return ChunkCache::Chunk();
  if (!complete) {
    if (auto status = fill_.complete(*posts); !status) return status.error();
  }
  std::vector<float> out(positions.at.size());
  std::vector<std::uint8_t> met(complete ? 0 : out.size(), 0);
  resampler_.resample(posts->heights, fitted, shifts_of(*posts), positions, fit_tolerance(), out, met);
  return cut_out(window, positions, *posts, out, met);
}

Result<ProjectedGroup::Block> ProjectedGroup::block_at(std::int64_t x, std::int64_t y) const {
  const SampleWindow window = window_of_block(x, y);
  const std::uint64_t place = (static_cast<std::uint64_t>(y) << 32) + static_cast<std::uint64_t>(x);
  auto bytes = blocks_->get({number_, place}, [&] { return make_block(window); });
  if (!bytes) return bytes.error();
  return Block{std::move(*bytes), window.count()};
}

// Puts the posts in the closed window at their places, each once, also where the window goes around the
// Earth.
Status ProjectedGroup::add_posts(const SampleWindow& window, MeasuredPosts& posts) const {
  const IndexWindow wanted = resampler_.posts_near(grown(window, 0));
  if (wanted.x.count() <= 0 || wanted.y.count() <= 0) return {};
  const auto read = read_posts(wanted.x, wanted.y);
  if (!read) return read.error();
  const double around = resampler_.around();
  const bool wide = window.columns > around / 2;
  posts.placed.reserve(read->owners.size());
  const auto add_row = [&](std::int64_t row, std::span<const PlanePoint> places) {
    for (int c = 0; c < read->columns; ++c) {
      const std::size_t at = read->index(c, static_cast<int>(row - read->j0));
      if (!PostBlock::has_value(read->owners[at])) continue;
      const PlanePoint& place = places[static_cast<std::size_t>(c)];
      const double x = wide ? place.x - around * std::floor(place.x / around) : place.x;
      const double px = x - static_cast<double>(window.column);
      const double py = place.y - static_cast<double>(window.row);
      if (!(px >= 0 && py >= 0 && px <= window.columns - 1 && py <= window.rows - 1)) continue;
      posts.placed.push_back({px, py, read->heights[at], read->owners[at]});
    }
  };
  resampler_.visit_places(wanted, grown(window, 0), shifts_of(*read), add_row);
  return {};
}

Result<MeasuredPosts> ProjectedGroup::posts(const SampleWindow& window) const {
  MeasuredPosts posts;
  if (auto status = add_posts(window, posts); !status) return status.error();
  return posts;
}

// In the area of these members, to which belongs what lies between four posts of theirs.
LonLat ProjectedGroup::nearest_to(LonLat place, const std::vector<IndexWindow>& extents) const {
  const LonLat far_away{place.lon + 360, place.lat};
  const auto post = grid_.georeference.post_at(place);
  if (!std::isfinite(post.column) || !std::isfinite(post.row)) return far_away;
  const auto is_covered = [&](double column, double row) {
    const auto c = static_cast<std::int64_t>(column), r = static_cast<std::int64_t>(row);
    return std::any_of(extents.begin(), extents.end(),
                       [&](const IndexWindow& e) { return e.x.holds(c) && e.y.holds(r); });
  };
  const double c0 = std::floor(post.column), c1 = std::ceil(post.column);
  const double r0 = std::floor(post.row), r1 = std::ceil(post.row);
  if (is_covered(c0, r0) && is_covered(c1, r0) && is_covered(c0, r1) && is_covered(c1, r1)) return place;
  double least = std::numeric_limits<double>::infinity();
  Georeference::ColumnRow nearest;
  for (const IndexWindow& e : extents) {
    const double column =
        std::clamp(post.column, static_cast<double>(e.x.first), static_cast<double>(e.x.last));
    const double row = std::clamp(post.row, static_cast<double>(e.y.first), static_cast<double>(e.y.last));
    const double away = std::hypot(column - post.column, row - post.row);
    if (away >= least) continue;
    least = away;
    nearest = {column, row};
  }
  if (!std::isfinite(least)) return far_away;
  if (least == 0) return place;
  LonLat rim = grid_.georeference.place_of(nearest.column, nearest.row);
  rim.lon = place.lon + std::remainder(rim.lon - place.lon, 360);
  return rim;
}

NearestPlace ProjectedGroup::nearest_within(const GeoBounds& area, double margin) const {
  const GeoBounds bounds = widened(area, margin);
  const auto sample_of = [&](double degrees, double origin) {
    return static_cast<std::int64_t>(std::floor((degrees + origin) * samples_per_degree_));
  };
  const IndexWindow samples{{sample_of(bounds.west - margin, 180), sample_of(bounds.east + margin, 180) + 1},
                            {sample_of(std::max(bounds.south - margin, -90.0), 90),
                             sample_of(std::min(bounds.north + margin, 90.0), 90) + 1}};
  std::vector<IndexWindow> extents;
  for (const std::size_t member : members_.overlapping(resampler_.posts_near(samples)))
    extents.push_back(members_.extents()[member]);
  return [this, extents = std::move(extents)](LonLat place) { return nearest_to(place, extents); };
}

void ProjectedGroup::take_block(const SampleWindow& from, const Block& block, const SampleWindow& window,
                                GroupSamples& samples) const {
  const std::int64_t west = std::max(window.column, from.column);
  const std::int64_t east = std::min(window.column + window.columns, from.column + from.columns);
  const std::int64_t north = std::min(window.row + window.rows, from.row + from.rows);
  const SampleState* states = block.states();
  for (std::int64_t r = std::max(window.row, from.row); r < north; ++r) {
    const std::int64_t first = (r - from.row) * from.columns + (west - from.column);
    const std::int64_t to = (r - window.row) * window.columns + (west - window.column);
    std::copy_n(block.heights() + first, east - west, samples.heights.begin() + to);
    if (states == nullptr) {
      std::fill_n(samples.states.begin() + to, east - west, SampleState::sourced);
    } else {
      std::copy_n(states + first, east - west, samples.states.begin() + to);
    }
  }
}

void ProjectedGroup::set_reach(double solid_degrees, double fade_degrees) {
  solid_posts_ = solid_degrees / spacing_degrees_;
  fade_posts_ = std::min(fade_degrees / spacing_degrees_, kMostFadePosts);
}

// Puts in how many posts the window's samples that lie in a block are from one with a value, up to where a
// void's fill ends.
Status ProjectedGroup::add_void_depths(const SampleWindow& block, const SampleWindow& window,
                                       std::vector<double>& depths) const {
  const SamplePositions positions = resampler_.positions_of(grown(block, 0));
  if (positions.posts.count() <= 0) return {};
  const double farthest = std::max(solid_posts_ + fade_posts_, void_posts_.value_or(0));
  const auto reach = static_cast<std::int64_t>(std::ceil(farthest)) + 1;
  const auto posts = read_posts({positions.posts.x.first - reach, positions.posts.x.last + reach},
                                {positions.posts.y.first - reach, positions.posts.y.last + reach});
  if (!posts) return posts.error();
  const std::vector<int> distances = distances_to_values(*posts, static_cast<int>(reach));
  const std::int64_t east = std::min(block.column + block.columns, window.column + window.columns);
  const std::int64_t north = std::min(block.row + block.rows, window.row + window.rows);
  for (std::int64_t r = std::max(block.row, window.row); r < north; ++r) {
    for (std::int64_t c = std::max(block.column, window.column); c < east; ++c) {
      const PlanePoint& at = positions.at[positions.samples.offset(c, r)];
      if (std::isnan(at.x)) continue;
      depths[static_cast<std::size_t>((r - window.row) * window.columns + c - window.column)] = distance_at(
          *posts, distances, at.x - static_cast<double>(posts->i0), at.y - static_cast<double>(posts->j0));
    }
  }
  return {};
}

Result<GroupSamples> ProjectedGroup::sample(const SampleWindow& window) const {
  assert(window.samples_per_degree == samples_per_degree_);
  GroupSamples samples;
  samples.heights.assign(window.count(), kNoHeight);
  samples.states.assign(window.count(), SampleState::none);
  std::vector<double> depths;  // empty while no sample is filled
  const std::int64_t east = window.column + window.columns;
  const std::int64_t north = window.row + window.rows;
  for (std::int64_t by = floor_divide(window.row, block_side_); by * block_side_ < north; ++by) {
    for (std::int64_t bx = floor_divide(window.column, block_side_); bx * block_side_ < east; ++bx) {
      const auto block = block_at(bx, by);
      if (!block) return block.error();
      if (block->is_empty()) continue;
      take_block(window_of_block(bx, by), *block, window, samples);
      if ((fade_posts_ == 0 && !void_posts_) || !has_filled(block->states(), block->count)) continue;
      depths.resize(window.count(), HUGE_VAL);
      if (auto status = add_void_depths(window_of_block(bx, by), window, depths); !status)
        return status.error();
    }
  }
  if (!depths.empty()) end_voids(depths, {solid_posts_, fade_posts_, void_posts_}, samples);
  if (auto status = add_posts(window, samples.posts); !status) return status.error();
  return samples;
}

}  // namespace cairn
