#include "builder/mosaic/void_end.h"

#include <limits>

#include "builder/mosaic/fade_weight.h"

namespace cairn {

void end_voids(std::span<const double> depths, const VoidEnd& end, GroupSamples& samples) {
  if (end.fade > 0) samples.fill_weights.resize(depths.size());
  for (std::size_t i = 0; i < depths.size(); ++i) {
    if (end.fade > 0)
      samples.fill_weights[i] = static_cast<float>(fade_weight(depths[i] - end.solid, end.fade));
    if (samples.states[i] != SampleState::filled || !end.filled || depths[i] <= *end.filled) continue;
    samples.states[i] = SampleState::none;
    samples.heights[i] = std::numeric_limits<float>::quiet_NaN();
  }
}

}  // namespace cairn
