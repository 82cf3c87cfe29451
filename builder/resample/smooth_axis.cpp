#include "builder/resample/smooth_axis.h"

#include <algorithm>
#include <cassert>

#include "builder/resample/cubic_kernel.h"
#include "builder/resample/exact_run.h"

namespace cairn {
namespace {

constexpr std::int64_t kSmoothingReach = 2;  // posts to each side

IndexRange hull(IndexRange a, IndexRange b) {
  if (a.count() <= 0) return b;
  if (b.count() <= 0) return a;
  return {std::min(a.first, b.first), std::max(a.last, b.last)};
}

bool lies_on_sample(const AxisPositions& positions, std::int64_t post) {
  return positions.fraction_of(post) == 0;
}

}  // namespace

SmoothAxis::SmoothAxis(const AxisPositions& positions, IndexRange wanted) {
  assert(wanted.count() > 0);
  for (std::int64_t k = wanted.first; k <= wanted.last; k = groups.back().samples.last + 1)
    add_group(positions, k);
  samples = {groups.front().samples.first, groups.back().samples.last};
  guess.samples = correction.samples = samples;
  for (std::int64_t k = samples.first; k <= samples.last; ++k) {
    const PostTaps taps = taps_at(positions, k, ResampleMethod::cubic);
    guess.append(taps.first, taps.weights());
    const std::int64_t next = positions.first_post_from(k);
    cells.push_back(positions.is_on_post(k) ? IndexRange{next, next} : IndexRange{next - 1, next});
  }
  for (std::int64_t post = corrected.first; post <= corrected.last; ++post) add_surface_at(positions, post);
  find_posts(positions);
}

void SmoothAxis::add_group(const AxisPositions& positions, std::int64_t sample) {
  if (positions.is_on_post(sample)) {
    const std::int64_t post = positions.first_post_from(sample);
    groups.push_back({{sample, sample}, {post, post}});
    correction.append(post, std::vector<double>{1});
  } else if (const auto run = run_at(positions, sample)) {
    groups.push_back({run->samples, run->posts});
    append_correction_rows(positions, *run, correction);
  } else {
    groups.push_back({{sample, sample}, {}});
    correction.append(positions.first_post_from(sample), {});
  }
  corrected = hull(corrected, groups.back().posts);
}

void SmoothAxis::add_surface_at(const AxisPositions& positions, std::int64_t post) {
  const std::int64_t below = positions.interval_of(post);
  const double t = positions.fraction_of(post);
  interval.push_back(below);
  fraction.push_back(t);
  const AxisWeights::Row& first = guess_row(below);
  if (t == 0) return guess_at_posts.append(first.first, std::vector<double>{1});
  const AxisWeights::Row& second = guess_row(below + 1);
  const std::int64_t from = std::min(first.first, second.first);
  const std::int64_t end = std::max(first.first + first.count, second.first + second.count);
  std::vector<double> weights(static_cast<std::size_t>(end - from));
  const auto add = [&](double factor, const AxisWeights::Row& row) {
    for (std::size_t c = 0; c < static_cast<std::size_t>(row.count); ++c)
      weights[static_cast<std::size_t>(row.first - from) + c] += factor * guess.weights_of(row)[c];
  };
  add(1 - t, first);
  add(t, second);
  guess_at_posts.append(from, weights);
}

IndexRange SmoothAxis::posts_around(IndexRange of) const {
  IndexRange around = of;
  for (std::int64_t post = of.first; post <= of.last; ++post) {
    if (!is_pinned(post)) around = hull(around, {post - kSmoothingReach, post + kSmoothingReach});
  }
  return around;
}

void SmoothAxis::find_posts(const AxisPositions& positions) {
  smoothed = hull(posts_of(guess.rows), corrected);
  for (std::int64_t post = smoothed.first; post <= smoothed.last; ++post) {
    const std::int64_t reach = lies_on_sample(positions, post) ? 0 : kSmoothingReach;
    posts = hull(posts, {post - reach, post + reach});
  }
  for (std::int64_t post = posts.first; post <= posts.last; ++post)
    pinned.push_back(lies_on_sample(positions, post) ? 1 : 0);
}

}  // namespace cairn
