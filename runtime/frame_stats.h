#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace cairn {

/// What the reports say about a set of measurements. All zero where there is none.
struct Summary {
  std::size_t count = 0;
  double min = 0;
  double max = 0;
  double mean = 0;
  double p50 = 0;  ///< percentiles by nearest rank: the smallest measurement that p % do not exceed
  double p95 = 0;
  double p99 = 0;
};

Summary summarize(std::vector<double> samples);

/// The smallest of the samples that at least `percent` % of them do not exceed. REQUIRES: ascending, not
/// empty, 0 < percent <= 100.
double nearest_rank(std::span<const double> ascending, double percent);

}  // namespace cairn
