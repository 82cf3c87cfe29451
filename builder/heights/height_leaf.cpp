#include "builder/heights/height_leaf.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "builder/heights/ancestor_errors.h"
#include "builder/heights/error_stats.h"
#include "builder/heights/geometric_error.h"
#include "builder/heights/quantize_tile.h"
#include "builder/resample/post_block.h"
#include "format/simd_clones.h"

namespace cairn {
namespace {

// Measures the surfaces that a leaf has at its own level and at those above it, against the posts that won
// there and against its samples.
class LeafErrors {
 public:
  // `bounds_m`: by group of posts. REQUIRES: tile, posts and bounds outlive this.
  LeafErrors(const HeightTile& tile, double quantum_m, std::span<const MeasuredPosts> posts,
             std::span<const double> bounds_m, const PostCounting& counting);

  // Of the leaf itself, against the posts.
  const SurfaceError& own() const { return own_; }
  const ErrorStats& own_stats() const { return own_stats_; }

  // How far the surface `up` levels above is from the posts and from the leaf's samples: what the scene sees
  // of a coarser tile is its distance from the finest, between the posts too.
  double max_m(int up) const;

  // Whether that surface keeps the least error bound of the posts; `max_m` is max_m(up).
  bool keeps(int up, double max_m) const;

  // Every counted post's error there; `max_m` is max_m(up).
  ErrorStats stats(int up, double max_m) const;

 private:
  SurfaceError of_posts(int up) const;
  MeasuredPosts samples_as_posts() const;

  const HeightTile& tile_;
  double quantum_m_;
  std::span<const MeasuredPosts> posts_;
  std::span<const double> bounds_m_;
  double least_bound_m_ = HUGE_VAL;  // of groups that have a post here
  PostCounting counting_;
  SurfaceError own_;
  ErrorStats own_stats_;
  PostErrors own_errors_;
  std::optional<AncestorErrors> ancestors_;  // unset where only each post by itself can be measured
};

SurfaceError worse_of(const SurfaceError& a, const SurfaceError& b) {
  return {std::max(a.max_m, b.max_m), a.has_holes || b.has_holes};
}

bool has_post(const MeasuredPosts& posts) {
  return !posts.placed.empty() || std::any_of(posts.heights.begin(), posts.heights.end(),
                                              [](float height) { return !std::isnan(height); });
}

LeafErrors::LeafErrors(const HeightTile& tile, double quantum_m, std::span<const MeasuredPosts> posts,
                       std::span<const double> bounds_m, const PostCounting& counting)
    : tile_(tile), quantum_m_(quantum_m), posts_(posts), bounds_m_(bounds_m), counting_(counting) {
  for (std::size_t g = 0; g < posts_.size(); ++g) {
    own_stats_.add_bounded(bounds_m_[g], [&](ErrorStats& stats) {
      own_ = worse_of(own_, measure_own_surface(tile_, quantum_m_, posts_[g], counting_, stats, own_errors_));
    });
    if (bounds_m_[g] < least_bound_m_ && has_post(posts_[g])) least_bound_m_ = bounds_m_[g];
  }
  if (AncestorErrors::can_measure(tile_)) ancestors_.emplace(tile_, quantum_m_, posts_, own_errors_);
}

double LeafErrors::max_m(int up) const {
  if (ancestors_) return ancestors_->max_m(up);
  return std::max(of_posts(up).max_m, measure_surface(tile_, quantum_m_, up, samples_as_posts()).max_m);
}

bool LeafErrors::keeps(int up, double max_m) const {
  if (ancestors_) return max_m <= least_bound_m_ || !ancestors_->any_post_beyond(up, least_bound_m_);
  const SurfaceError error = of_posts(up);
  return error.max_m <= least_bound_m_ && !error.has_holes;
}

ErrorStats LeafErrors::stats(int up, double max_m) const {
  if (max_m == 0 && own_.max_m == 0 && !own_.has_holes) return own_stats_;
  ErrorStats stats;
  for (std::size_t g = 0; g < posts_.size(); ++g) {
    stats.add_bounded(bounds_m_[g], [&](ErrorStats& of_group) {
      measure_surface(tile_, quantum_m_, up, posts_[g], counting_, of_group);
    });
  }
  return stats;
}

SurfaceError LeafErrors::of_posts(int up) const {
  SurfaceError worst;
  for (const auto& p : posts_) worst = worse_of(worst, measure_surface(tile_, quantum_m_, up, p));
  return worst;
}

MeasuredPosts LeafErrors::samples_as_posts() const {
  MeasuredPosts samples;
  for (int i = 0; i < tile_.size; ++i) samples.xs.push_back(i);
  samples.ys = samples.xs;
  samples.heights.reserve(tile_.samples.size());
  for (std::size_t i = 0; i < tile_.samples.size(); ++i) {
    const bool is_void = !tile_.voids.empty() && tile_.voids[i] != 0;
    samples.heights.push_back(is_void ? std::numeric_limits<float>::quiet_NaN()
                                      : static_cast<float>(tile_.samples[i] * quantum_m_));
  }
  return samples;
}

// Measures level by level, upwards. A tile can be pruned while the next coarser surface keeps the error
// bound, too, or while its level is finer than any that is stored.
void measure_levels(const HeightPlan& plan, const MosaicTile& sampled, HeightNode& node) {
  const PostCounting counting = plan.counting(node.id);
  std::vector<double> bounds_m;
  for (const std::size_t g : sampled.groups) bounds_m.push_back(plan.error_bound_m(g));
  const LeafErrors errors(node.tile, plan.quantum_m(), sampled.posts, bounds_m, counting);
  node.candidate_stats.push_back(errors.own_stats());
  node.errors_m.push_back(errors.own().max_m);
  bool may_prune = true;
  for (int up = 1; node.id.level - up >= plan.top() && (plan.tile_size() - 1) % (1 << up) == 0; ++up) {
    const double max_m = errors.max_m(up);
    const bool too_fine = node.id.level - up >= plan.finest();
    may_prune = may_prune && (too_fine || errors.keeps(up, max_m));
    if (may_prune) node.candidate_stats.push_back(errors.stats(up, max_m));
    node.errors_m.push_back(std::max(max_m, node.errors_m.back()));
  }
}

CAIRN_SIMD_CLONES bool any_other_or_void(const std::uint16_t* owners, const float* heights,
                                         std::size_t count) {
  int other = 0;  // no early end, so that the loop is one of vectors
  for (std::size_t i = 0; i < count; ++i)
    other |= (owners[i] ^ owners[0]) | (heights[i] != heights[i] ? 1 : 0);
  return other != 0;
}

// Whether one source gave all the posts, none of which is void or has lost.
bool is_of_one_source(const MeasuredPosts& posts) {
  if (posts.owners.empty() || !posts.placed.empty()) return false;
  return !any_other_or_void(posts.owners.data(), posts.heights.data(), posts.owners.size());
}

void count_winners_of(const MeasuredPosts& posts, const std::vector<std::size_t>& sources,
                      const PostCounting& counting, std::vector<std::uint64_t>& won) {
  if (is_of_one_source(posts)) {
    won[sources[posts.owners.front() - 1u]] += counting.count(posts);
    return;
  }
  for (std::size_t r = 0; r < posts.ys.size(); ++r) {
    for (std::size_t c = 0; c < posts.xs.size(); ++c) {
      const std::size_t post = r * posts.xs.size() + c;
      if (std::isnan(posts.heights[post]) || !counting.counts(posts.xs[c], posts.ys[r])) continue;
      ++won[sources[posts.owners[post] - 1u]];
    }
  }
  for (const auto& p : posts.placed) {
    if (counting.counts(p.x, p.y)) ++won[sources[p.owner - 1u]];
  }
}

void count_losers_of(const MeasuredPosts& posts, const std::vector<std::size_t>& sources,
                     const PostCounting& counting, std::vector<std::uint64_t>& lost) {
  for (std::size_t r = 0; r < posts.ys.size(); ++r) {
    for (std::size_t c = 0; c < posts.xs.size(); ++c) {
      const std::size_t post = r * posts.xs.size() + c;
      const std::uint16_t owner = posts.owners[post];
      if (!std::isnan(posts.heights[post]) || !PostBlock::has_value(owner)) continue;
      if (counting.counts(posts.xs[c], posts.ys[r])) ++lost[sources[owner - 1u]];
    }
  }
  for (const auto& p : posts.lost) {
    if (counting.counts(p.x, p.y)) ++lost[sources[p.owner - 1u]];
  }
}

std::vector<std::uint64_t> count_losers(const Mosaic& mosaic, const MosaicTile& tile,
                                        const PostCounting& counting) {
  std::vector<std::uint64_t> lost(mosaic.pool().size(), 0);
  // The first group has none above it.
  for (std::size_t g = 1; g < tile.posts.size(); ++g)
    count_losers_of(tile.posts[g], mosaic.groups()[tile.groups[g]]->sources(), counting, lost);
  return lost;
}

std::vector<std::uint64_t> count_winners(const Mosaic& mosaic, const MosaicTile& tile,
                                         const PostCounting& counting) {
  std::vector<std::uint64_t> won(mosaic.pool().size(), 0);
  for (std::size_t g = 0; g < tile.posts.size(); ++g)
    count_winners_of(tile.posts[g], mosaic.groups()[tile.groups[g]]->sources(), counting, won);
  return won;
}

}  // namespace

Result<SampledLeaf> sample_leaf(const Mosaic& mosaic, const HeightPlan& plan, const TileId& id,
                                VoidMode voids) {
  auto sampled = mosaic.sample(id);
  if (!sampled) return sampled.error();
  std::vector<std::uint8_t> single;
  if (plan.whole_metre_step() > 1) single = mosaic.near_fractions(id);
  const HeightSteps steps{plan.quantum_m(), plan.whole_metre_step(), single};
  QuantizedTile quantized = quantize_tile(*sampled, plan.tile_size(), steps, voids);
  SampledLeaf leaf;
  leaf.node.id = id;
  leaf.node.tile = std::move(quantized.tile);
  leaf.node.filled = quantized.filled;
  leaf.node.edge_only = plan.tree().edge_only(id);
  leaf.sampled = std::move(*sampled);
  return leaf;
}

HeightNode measure_leaf(const Mosaic& mosaic, const HeightPlan& plan, SampledLeaf leaf) {
  HeightNode node = std::move(leaf.node);
  if (node.edge_only) return node;
  measure_levels(plan, leaf.sampled, node);
  node.posts_used = count_winners(mosaic, leaf.sampled, plan.counting(node.id));
  node.posts_lost = count_losers(mosaic, leaf.sampled, plan.counting(node.id));
  return node;
}

}  // namespace cairn
