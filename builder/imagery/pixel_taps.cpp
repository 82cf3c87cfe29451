#include "builder/imagery/pixel_taps.h"

#include <algorithm>
#include <cmath>

namespace cairn {
namespace {

double cubic(double x) {
  const double d = std::abs(x);
  if (d < 1) return (1.5 * d - 2.5) * d * d + 1;
  if (d < 2) return ((-0.5 * d + 2.5) * d - 4) * d + 2;
  return 0;
}

double scale_at(const std::vector<double>& positions, std::size_t i) {
  if (positions.size() < 2) return 1;
  const std::size_t a = i > 0 ? i - 1 : 0;
  const std::size_t b = std::min(i + 1, positions.size() - 1);
  return std::max(1.0, std::abs(positions[b] - positions[a]) / static_cast<double>(b - a));
}

}  // namespace

int taps_for(double scale) {
  return static_cast<int>(std::ceil(4 * scale - 1e-9));
}

std::int64_t first_tap(double position, double scale) {
  return static_cast<std::int64_t>(std::floor(position - 2 * scale)) + 1;
}

void tap_weights(double position, double scale, int count, float* weights) {
  const double offset = static_cast<double>(first_tap(position, scale)) - position;
  double sum = 0;
  for (int i = 0; i < count; ++i) sum += cubic((offset + i) / scale);
  for (int i = 0; i < count; ++i) weights[i] = static_cast<float>(cubic((offset + i) / scale) / sum);
}

PixelTaps taps_along(const std::vector<double>& positions) {
  PixelTaps taps;
  for (std::size_t i = 0; i < positions.size(); ++i)
    taps.count = std::max(taps.count, taps_for(scale_at(positions, i)));
  taps.weights.resize(positions.size() * static_cast<std::size_t>(taps.count));
  for (std::size_t i = 0; i < positions.size(); ++i) {
    const double scale = scale_at(positions, i);
    taps.first.push_back(first_tap(positions[i], scale));
    tap_weights(positions[i], scale, taps.count, &taps.weights[i * static_cast<std::size_t>(taps.count)]);
  }
  return taps;
}

}  // namespace cairn
