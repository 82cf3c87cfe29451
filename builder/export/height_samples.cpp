#include "builder/export/height_samples.h"

namespace cairn {

double HeightSamples::bilinear_at(std::int64_t x, std::int64_t y) const {
  const double along = static_cast<double>(x % step) / static_cast<double>(step);
  const double up = static_cast<double>(y % step) / static_cast<double>(step);
  double sum = 0;
  for (const int dr : {0, 1})
    for (const int dc : {0, 1}) {
      const double weight = (dc == 0 ? 1 - along : along) * (dr == 0 ? 1 - up : up);
      if (weight == 0) continue;
      sum += weight * static_cast<double>(
                          metres[index(static_cast<int>(x / step) + dc, static_cast<int>(y / step) + dr)]);
    }
  return sum;
}

}  // namespace cairn
