#include "builder/resample/cubic_kernel.h"

#include <cmath>

namespace cairn {

std::array<double, 4> catmull_rom(double f) {
  const double f2 = f * f;
  const double f3 = f2 * f;
  return {-0.5 * f3 + f2 - 0.5 * f, 1.5 * f3 - 2.5 * f2 + 1, -1.5 * f3 + 2 * f2 + 0.5 * f,
          0.5 * f3 - 0.5 * f2};
}

PostTaps taps_at(const AxisPositions& axis, std::int64_t sample, ResampleMethod method) {
  const std::int64_t on = axis.first_post_from(sample);
  if (axis.position(on) == static_cast<double>(sample)) return {on, 1, {1}};
  const std::int64_t below = on - 1;
  const double f = axis.post_coordinate(sample) - static_cast<double>(below);
  switch (method) {
    case ResampleMethod::nearest:
      return {f < 0.5 ? below : on, 1, {1}};
    case ResampleMethod::bilinear:
      return {below, 2, {1 - f, f}};
    case ResampleMethod::cubic:
    case ResampleMethod::exact:
    case ResampleMethod::smooth:
      break;
  }
  return {below - 1, 4, catmull_rom(f)};
}

}  // namespace cairn
