#include "builder/export/wgs84.h"

#include <cmath>
#include <numbers>

namespace cairn {
namespace {

constexpr double kRadian = std::numbers::pi / 180;

}  // namespace

DegreeLengths degree_lengths(double lat) {
  const double e2 = 1 - (kPoleRadius_m * kPoleRadius_m) / (kEquatorRadius_m * kEquatorRadius_m);
  const double s = std::sin(lat * kRadian), w = 1 - e2 * s * s;
  return {kRadian * std::cos(lat * kRadian) * kEquatorRadius_m / std::sqrt(w),
          kRadian * kEquatorRadius_m * (1 - e2) / (w * std::sqrt(w))};
}

}  // namespace cairn
