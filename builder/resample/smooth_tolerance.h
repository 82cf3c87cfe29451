#pragma once

namespace cairn {

/// How far smooth resampling may leave the posts, in metres.
struct SmoothTolerance {
  double interval_m = 0;   ///< of the surface at every post; ≥ 0
  double overshoot_m = 0;  ///< of a sample, beyond what the posts around it justify; ≥ 0
};

}  // namespace cairn
