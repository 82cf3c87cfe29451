#include "runtime/paging/frame_stats.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>

namespace cairn {

double nearest_rank(std::span<const double> ascending, double percent) {
  assert(!ascending.empty() && percent > 0 && percent <= 100);
  const double rank = std::ceil(percent / 100 * static_cast<double>(ascending.size()));
  return ascending[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

Summary summarize(std::vector<double> samples) {
  if (samples.empty()) return {};
  std::sort(samples.begin(), samples.end());
  const double sum = std::accumulate(samples.begin(), samples.end(), 0.0);
  return {samples.size(),
          samples.front(),
          samples.back(),
          sum / static_cast<double>(samples.size()),
          nearest_rank(samples, 50),
          nearest_rank(samples, 95),
          nearest_rank(samples, 99)};
}

void RecentSamples::add(double sample) {
  if (samples_.size() < kKept) {
    samples_.push_back(sample);
  } else {
    samples_[next_] = sample;
  }
  next_ = (next_ + 1) % kKept;
}

}  // namespace cairn
