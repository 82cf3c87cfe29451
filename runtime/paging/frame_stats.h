#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "cairn/paging_stats.h"

namespace cairn {

/// Sorts the measurements and summarizes them.
Summary summarize(std::vector<double> samples);

/// The smallest of the samples that at least `percent` % of them do not exceed. REQUIRES: ascending, not
/// empty, 0 < percent <= 100.
double nearest_rank(std::span<const double> ascending, double percent);

/// The last few thousand measurements of something that goes on for hours.
class RecentSamples {
 public:
  void add(double sample);
  Summary summary() const { return summarize(samples_); }

 private:
  static constexpr std::size_t kKept = 4096;
  std::vector<double> samples_;
  std::size_t next_ = 0;
};

}  // namespace cairn
