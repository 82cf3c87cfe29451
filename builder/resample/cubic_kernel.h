#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "builder/resample/axis_weights.h"

namespace cairn {

/// Catmull-Rom weights of the posts at -1, 0, 1 and 2 for the place f, 0 ≤ f ≤ 1 (Keys 1981, eq. 4, a =
/// -1/2).
std::array<double, 4> catmull_rom(double f);

/// Weights of up to four consecutive posts.
struct PostTaps {
  std::int64_t first = 0;
  std::int32_t count = 0;
  std::array<double, 4> values{};

  std::int64_t last() const { return first + count - 1; }
  std::span<const double> weights() const { return {values.data(), static_cast<std::size_t>(count)}; }
};

/// The method's interpolant at a sample, exact standing for its first guess, cubic; the post alone where the
/// sample lies on one.
PostTaps taps_at(const AxisPositions& axis, std::int64_t sample, ResampleMethod method);

}  // namespace cairn
