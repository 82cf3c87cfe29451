#pragma once

namespace cairn {

/// What a source counts where it fades into those beneath it: 1 up to where it begins to fade, 0 once it is
/// `fade` farther, smooth in between. A fade of 0 is a step.
inline double fade_weight(double beyond, double fade) {
  if (beyond <= 0) return 1;
  if (beyond >= fade) return 0;
  const double t = 1 - beyond / fade;
  return t * t * (3 - 2 * t);
}

/// Posts over which a group fades into its voids, at most: all of them have to be read around each tile.
inline constexpr double kMostFadePosts = 256;

}  // namespace cairn
