#include "builder/resample/axis_resampler.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "builder/resample/cubic_kernel.h"
#include "builder/resample/exact_run.h"

namespace cairn {

AxisResampler::AxisResampler(LatticeAxis axis, double samples_per_degree, ResampleMethod method)
    : positions_(axis, samples_per_degree), method_(method) {}

std::int64_t AxisResampler::longest_run() const {
  if (positions_.all_posts_on_samples()) return 0;
  // Fractions of adjacent posts of a run differ by ratio - 1, and all lie strictly between 0 and 1.
  const double excess = positions_.ratio() - 1;
  const double most = std::ceil(1 / excess);
  return excess > 0 && most < 1e15 ? static_cast<std::int64_t>(most)
                                   : std::numeric_limits<std::int64_t>::max();
}

bool AxisResampler::is_well_conditioned() const {
  constexpr std::int64_t longest_allowed = 32;
  const bool needs_runs = method_ == ResampleMethod::exact || method_ == ResampleMethod::smooth;
  return !needs_runs || longest_run() <= longest_allowed;
}

IndexRange AxisResampler::posts_at(std::int64_t sample) const {
  if (method_ == ResampleMethod::exact && !positions_.is_on_post(sample)) {
    if (const auto run = run_at(positions_, sample)) return posts_under(positions_, *run);
  }
  const PostTaps taps = taps_at(positions_, sample, method_);
  return {taps.first, taps.last()};
}

IndexRange AxisResampler::posts_for(IndexRange samples) const {
  assert(is_well_conditioned() && samples.count() > 0);
  IndexRange posts = posts_at(samples.first);
  // A sample on a post needs that post only, but its neighbour inside the window needs posts beyond.
  for (std::int64_t k :
       {std::min(samples.first + 1, samples.last), std::max(samples.last - 1, samples.first), samples.last}) {
    const IndexRange more = posts_at(k);
    posts = {std::min(posts.first, more.first), std::max(posts.last, more.last)};
  }
  return posts;
}

AxisWeights AxisResampler::weights_for(IndexRange samples) const {
  assert(is_well_conditioned() && samples.count() > 0);
  AxisWeights weights;
  weights.samples = samples;
  weights.rows.reserve(static_cast<std::size_t>(samples.count()));
  for (std::int64_t k = samples.first; k <= samples.last; ++k) {
    const bool may_run = method_ == ResampleMethod::exact && !positions_.is_on_post(k);
    if (const auto run = may_run ? run_at(positions_, k) : std::nullopt) {
      const std::int64_t last = std::min(run->samples.last, samples.last);
      append_exact_rows(positions_, *run, {k, last}, weights);
      k = last;
    } else {
      const PostTaps taps = taps_at(positions_, k, method_);
      weights.append(taps.first, taps.weights());
    }
  }
  return weights;
}

}  // namespace cairn
