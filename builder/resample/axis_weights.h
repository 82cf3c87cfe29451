#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "builder/resample/axis_positions.h"
#include "cairn/bake_choices.h"

namespace cairn {

/// Samples as weighted sums of posts: sample k is the sum of weights[offset + c] · post[first + c] over c <
/// count.
struct AxisWeights {
  struct Row {
    std::int64_t first = 0;
    std::int32_t offset = 0;
    std::int32_t count = 0;
  };
  IndexRange samples;
  std::vector<Row> rows;  ///< one a sample
  std::vector<double> weights;

  void append(std::int64_t first_post, std::span<const double> row);
  std::span<const double> weights_of(const Row& row) const;
};

/// The posts that the rows depend on. REQUIRES: rows not empty, each of a post at least.
IndexRange posts_of(std::span<const AxisWeights::Row> rows);

}  // namespace cairn
