#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "builder/resample/axis_positions.h"

namespace cairn {

/// How samples come from posts along an axis.
enum class ResampleMethod {
  nearest,   ///< the nearest post
  bilinear,  ///< between the two posts around the sample
  cubic,     ///< Catmull-Rom through the four posts around it (Keys 1981, a = -1/2)
  exact,     ///< cubic, corrected so that the samples' linear interpolant passes through every post
};

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

}  // namespace cairn
