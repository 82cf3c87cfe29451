#include "builder/mosaic/lattice_group.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <memory>

#include "builder/mosaic/fade_weight.h"
#include "builder/mosaic/fill_in_posts.h"
#include "builder/mosaic/void_end.h"
#include "builder/voids/void_distance.h"
#include "format/simd_clones.h"

namespace cairn {
namespace {

constexpr float kNoHeight = std::numeric_limits<float>::quiet_NaN();
constexpr std::int64_t kNeverWraps = std::int64_t{1} << 40;

IndexRange range_of(std::int64_t first, int count) {
  return {first, first + count - 1};
}

// Posts at or beyond the window's first sample, and at or before its last.
IndexRange posts_within(const AxisPositions& positions, IndexRange samples) {
  const std::int64_t first = positions.first_post_from(samples.first);
  std::int64_t last = positions.first_post_from(samples.last);
  if (positions.position(last) > static_cast<double>(samples.last)) --last;
  return {first, last};
}

CAIRN_SIMD_CLONES bool all_have_values(const std::vector<std::uint16_t>& owners) {
  int without = 0;  // no early end, likewise
  for (const std::uint16_t owner : owners) without |= PostBlock::has_value(owner) ? 0 : 1;
  return without == 0;
}

bool any_filled(const std::vector<SampleState>& states) {
  return std::find(states.begin(), states.end(), SampleState::filled) != states.end();
}

IndexRange hull(IndexRange a, IndexRange b) {
  if (b.count() <= 0) return a;
  return {std::min(a.first, b.first), std::max(a.last, b.last)};
}

// Whether `b`, moved around the Earth by whole turns, begins one post after `a` ends and lies beside it.
bool follows(const IndexRange& a, const IndexRange& b, std::int64_t around, const IndexRange& across_a,
             const IndexRange& across_b) {
  return (b.first - a.last - 1) % around == 0 && across_a.first <= across_b.last + 1 &&
         across_b.first <= across_a.last + 1;
}

std::vector<IndexWindow> extents_of(const RasterPool& pool,
                                    const std::vector<LatticeGroup::Member>& members) {
  std::vector<IndexWindow> extents;
  for (const auto& m : members) {
    const RasterInfo& info = pool.info(m.source);
    extents.push_back({{m.placement.i0, m.placement.i0 + info.columns - 1},
                       {m.placement.j0, m.placement.j0 + info.rows - 1}});
  }
  return extents;
}

}  // namespace

LatticeGroup::LatticeGroup(RasterPool& pool, const Geoid* geoid, const Lattice& lattice,
                           std::vector<Member> members, int native_level, double samples_per_degree,
                           ResampleMethod method)
    : pool_(pool),
      geoid_(geoid),
      lattice_(lattice),
      members_(std::move(members)),
      lon_(lattice.lon, samples_per_degree, method),
      lat_(lattice.lat, samples_per_degree, method),
      lon_positions_(lattice.lon, samples_per_degree),
      lat_positions_(lattice.lat, samples_per_degree),
      method_(method),
      around_(lattice.posts_around().value_or(kNeverWraps)),
      index_(extents_of(pool, members_)),
      fill_(index_.extents(), around_,
            [this](IndexRange columns, IndexRange rows) { return read_posts(columns, rows); }) {
  assert(members_.size() < PostBlock::kVoid - 1u);
  native_level_ = native_level;
  spacing_degrees_ = 1.0 / std::min(lattice.lon.posts_per_degree, lattice.lat.posts_per_degree);
  samples_per_post_ = std::min(lon_positions_.ratio(), lat_positions_.ratio());
  posts_on_samples_ = lon_positions_.all_posts_on_samples() && lat_positions_.all_posts_on_samples();
  for (const Member& m : members_) {
    const RasterInfo& info = pool.info(m.source);
    const std::int64_t east =
        info.columns == around_ ? m.placement.i0 + around_ : m.placement.i0 + info.columns - 1;
    footprint_.add({lattice.lon_of(m.placement.i0), lattice.lat_of(m.placement.j0), lattice.lon_of(east),
                    lattice.lat_of(m.placement.j0 + info.rows - 1)});
    sources_.push_back(m.source);
  }
  // Members that touch lie one post apart; what is between them is the group's.
  const std::vector<IndexWindow>& extents = index_.extents();
  for (std::size_t m = 0; m < extents.size(); ++m) {
    GeoBounds part = footprint_.rectangles()[m];
    bool east = false, north = false;
    const IndexWindow& e = extents[m];
    const IndexWindow beside{{e.x.first - 1, e.x.last + 1}, {e.y.first - 1, e.y.last + 1}};
    for (const auto& [number, turn] : index_.overlapping(beside, around_)) {
      const IndexWindow& other = extents[number];
      east = east || follows(e.x, other.x, around_, e.y, other.y);
      north = north || follows(e.y, other.y, kNeverWraps, e.x, other.x);
    }
    if (east) part.east = lattice_.lon_of(extents[m].x.last + 1);
    if (north) part.north = lattice_.lat_of(extents[m].y.last + 1);
    area_.add(part);
  }
}

void LatticeGroup::set_reach(double solid_degrees, double fade_degrees) {
  const double densest = std::max(lattice_.lon.posts_per_degree, lattice_.lat.posts_per_degree);
  solid_posts_ = solid_degrees * densest;
  fade_posts_ = std::min(fade_degrees * densest, kMostFadePosts);
  fill_.set_reach(static_cast<std::int64_t>(std::ceil(solid_posts_)));
}

// Copies the member's posts, shifted by `turn` posts around the Earth, to where the block has no value yet.
Status LatticeGroup::read_member(std::size_t member, std::int64_t turn, PostBlock& block) const {
  const LatticePlacement& place = members_[member].placement;
  const RasterInfo& info = pool_.info(members_[member].source);
  const std::int64_t west = std::max(block.i0, place.i0 + turn);
  const std::int64_t east = std::min(block.i0 + block.columns, place.i0 + turn + info.columns);
  const std::int64_t south = std::max(block.j0, place.j0);
  const std::int64_t north = std::min(block.j0 + block.rows, place.j0 + info.rows);
  if (west >= east || south >= north) return {};

  const std::int64_t first_row = place.north_up ? place.j0 + info.rows - north : south - place.j0;
  const PostWindow window{west - place.i0 - turn, first_row, east - west, north - south};
  const auto width = static_cast<std::size_t>(window.columns);
  const std::size_t count = width * static_cast<std::size_t>(window.rows);
  const auto read = std::make_unique_for_overwrite<float[]>(count);
  if (auto status = pool_.read_heights(members_[member].source, window, {read.get(), count}); !status)
    return status;

  const auto owner = static_cast<std::uint16_t>(member + 1);
  for (std::int64_t j = south; j < north; ++j) {
    const std::int64_t file_row = place.north_up ? north - 1 - j : j - south;
    const std::size_t to = block.index(static_cast<int>(west - block.i0), static_cast<int>(j - block.j0));
    fill_in_posts(read.get() + file_row * window.columns, width, owner, block.heights.data() + to,
                  block.owners.data() + to);
  }
  return {};
}

Result<PostBlock> LatticeGroup::read_posts(IndexRange columns, IndexRange rows) const {
  PostBlock block{
      columns.first, rows.first, static_cast<int>(columns.count()), static_cast<int>(rows.count()), {}, {}};
  const std::size_t count = static_cast<std::size_t>(block.columns) * static_cast<std::size_t>(block.rows);
  block.heights.assign(count, kNoHeight);
  block.owners.assign(count, PostBlock::kOutside);
  for (const auto& [member, turn] : index_.overlapping({columns, rows}, around_)) {
    if (auto status = read_member(member, turn, block); !status) return status.error();
  }
  if (geoid_ == nullptr) return block;
  for (int r = 0; r < block.rows; ++r) {
    for (int c = 0; c < block.columns; ++c) {
      const LonLat place{lattice_.lon_of(block.i0 + c), lattice_.lat_of(block.j0 + r)};
      block.heights[block.index(c, r)] += static_cast<float>(geoid_->undulation(place));
    }
  }
  return block;
}

std::vector<SampleState> LatticeGroup::states_of(const SampleWindow& window, const PostBlock& block) const {
  const auto best_of = [&](IndexRange columns, IndexRange rows) {
    SampleState best = SampleState::none;
    for (std::int64_t j = rows.first; j <= rows.last; ++j) {
      for (std::int64_t i = columns.first; i <= columns.last; ++i) {
        const std::uint16_t owner =
            block.owners[block.index(static_cast<int>(i - block.i0), static_cast<int>(j - block.j0))];
        if (PostBlock::has_value(owner)) return SampleState::sourced;
        if (owner == PostBlock::kVoid) best = SampleState::filled;
      }
    }
    return best;
  };
  const auto around = [](const AxisPositions& positions, std::int64_t sample) {
    const std::int64_t next = positions.first_post_from(sample);
    return positions.is_on_post(sample) ? IndexRange{next, next} : IndexRange{next - 1, next};
  };
  std::vector<IndexRange> columns;
  for (int c = 0; c < window.columns; ++c) columns.push_back(around(lon_positions_, window.column + c));
  std::vector<SampleState> states;
  states.reserve(window.count());
  for (int r = 0; r < window.rows; ++r) {
    const IndexRange rows = around(lat_positions_, window.row + r);
    for (const IndexRange& range : columns) states.push_back(best_of(range, rows));
  }
  return states;
}

// By sample how many posts it lies from one with a value, up to where a void's fill ends. Distances between
// posts are interpolated at samples, so that what depends on them is as smooth as they are.
Result<std::vector<double>> LatticeGroup::void_depths(const SampleWindow& window) const {
  const double farthest = std::max(solid_posts_ + fade_posts_, void_posts_.value_or(0));
  const auto reach = static_cast<std::int64_t>(std::ceil(farthest)) + 1;
  const IndexRange columns{lon_positions_.first_post_from(window.column) - 1,
                           lon_positions_.first_post_from(window.column + window.columns - 1)};
  const IndexRange rows{lat_positions_.first_post_from(window.row) - 1,
                        lat_positions_.first_post_from(window.row + window.rows - 1)};
  const auto block =
      read_posts({columns.first - reach, columns.last + reach}, {rows.first - reach, rows.last + reach});
  if (!block) return block.error();
  const std::vector<int> distances = distances_to_values(*block, static_cast<int>(reach));

  const auto places = [](const AxisPositions& positions, std::int64_t first, int count, std::int64_t origin) {
    std::vector<double> all;
    for (std::int64_t s = first; s < first + count; ++s)
      all.push_back(positions.post_coordinate(s) - static_cast<double>(origin));
    return all;
  };
  const auto xs = places(lon_positions_, window.column, window.columns, block->i0);
  std::vector<double> depths;
  depths.reserve(window.count());
  for (const double y : places(lat_positions_, window.row, window.rows, block->j0))
    for (const double x : xs) depths.push_back(distance_at(*block, distances, x, y));
  return depths;
}

MeasuredPosts LatticeGroup::posts_of(const SampleWindow& window, PostBlock&& block) const {
  const IndexRange columns = posts_within(lon_positions_, range_of(window.column, window.columns));
  const IndexRange rows = posts_within(lat_positions_, range_of(window.row, window.rows));
  MeasuredPosts posts;
  for (std::int64_t i = columns.first; i <= columns.last; ++i)
    posts.xs.push_back(lon_positions_.position(i) - static_cast<double>(window.column));
  for (std::int64_t j = rows.first; j <= rows.last; ++j)
    posts.ys.push_back(lat_positions_.position(j) - static_cast<double>(window.row));
  if (columns.count() == block.columns && rows.count() == block.rows) {
    posts.heights = std::move(block.heights);
    posts.owners = std::move(block.owners);
    return posts;
  }
  for (std::int64_t j = rows.first; j <= rows.last; ++j) {
    const auto at = static_cast<std::ptrdiff_t>(
        block.index(static_cast<int>(columns.first - block.i0), static_cast<int>(j - block.j0)));
    const std::ptrdiff_t end = at + columns.count();
    posts.heights.insert(posts.heights.end(), block.heights.begin() + at, block.heights.begin() + end);
    posts.owners.insert(posts.owners.end(), block.owners.begin() + at, block.owners.begin() + end);
  }
  return posts;
}

NearestPlace LatticeGroup::nearest_within(const GeoBounds& bounds, double margin) const {
  return [near = area_.near(bounds, 2 * margin)](LonLat place) { return near.nearest_to(place); };
}

Result<MeasuredPosts> LatticeGroup::posts(const SampleWindow& window) const {
  auto block = read_posts(posts_within(lon_positions_, range_of(window.column, window.columns)),
                          posts_within(lat_positions_, range_of(window.row, window.rows)));
  if (!block) return block.error();
  return posts_of(window, std::move(*block));
}

Result<GroupSamples> LatticeGroup::sample(const SampleWindow& window) const {
  const IndexRange columns = range_of(window.column, window.columns);
  const IndexRange rows = range_of(window.row, window.rows);
  const IndexWindow wanted = posts_for(columns, rows);
  auto block = read_posts(wanted.x, wanted.y);
  if (!block) return block.error();

  GroupSamples samples;
  samples.heights.resize(window.count());
  const IndexWindow to{columns, rows};
  if (all_have_values(block->owners)) {
    resample(wanted, block->heights, to, samples.heights);
    samples.posts = posts_of(window, std::move(*block));
    return samples;
  }
  samples.posts = posts_of(window, PostBlock(*block));
  samples.states = states_of(window, *block);
  if (auto status = fill_.complete(*block); !status) return status.error();
  resample(wanted, block->heights, to, samples.heights);
  if ((fade_posts_ == 0 && !void_posts_) || !any_filled(samples.states)) return samples;
  const auto depths = void_depths(window);
  if (!depths) return depths.error();
  end_voids(*depths, {solid_posts_, fade_posts_, void_posts_}, samples);
  return samples;
}

IndexWindow LatticeGroup::posts_for(IndexRange columns, IndexRange rows) const {
  if (method_ == ResampleMethod::smooth) {
    return {SmoothAxis(lon_positions_, columns).posts, SmoothAxis(lat_positions_, rows).posts};
  }
  return {hull(lon_.posts_for(columns), posts_within(lon_positions_, columns)),
          hull(lat_.posts_for(rows), posts_within(lat_positions_, rows))};
}

// REQUIRES: `from` is posts_for() of the samples.
void LatticeGroup::resample(const IndexWindow& from, std::span<const float> posts, const IndexWindow& samples,
                            std::span<float> out) const {
  if (method_ != ResampleMethod::smooth) return resample_lattice(lon_, lat_, from, posts, samples, out);
  smooth_lattice(SmoothAxis(lon_positions_, samples.x), SmoothAxis(lat_positions_, samples.y), tolerance_,
                 posts, samples, out);
}

}  // namespace cairn
