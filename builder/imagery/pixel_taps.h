#pragma once

#include <cstdint>
#include <vector>

namespace cairn {

/// Which pixels along one axis make up a texel, and their weights.
///
/// Where texels are no larger than pixels: cubic convolution with a = -1/2 (R. G. Keys, "Cubic convolution
/// interpolation for digital image processing", 1981). Where they are larger, the same kernel stretched to
/// the texel, so that what the texels cannot show is averaged away.
struct PixelTaps {
  std::vector<std::int64_t> first;  ///< the first pixel of each texel
  std::vector<float> weights;       ///< `count` of each texel; they add up to 1
  int count = 4;                    ///< the same for all
};

/// How many pixels make up a texel that is `scale` >= 1 pixels wide.
int taps_for(double scale);

/// The weights of the pixels from first_tap() on for a texel centred at `position` (0 is the first pixel's
/// centre). REQUIRES: count = taps_for(of a scale >= this one).
std::int64_t first_tap(double position, double scale);
void tap_weights(double position, double scale, int count, float* weights);

/// Taps of texels centred at these positions, which go up or down all along.
PixelTaps taps_along(const std::vector<double>& positions);

}  // namespace cairn
