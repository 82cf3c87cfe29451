#pragma once

#include <optional>
#include <span>

#include "builder/mosaic/source_group.h"

namespace cairn {

/// How a group ends inside its voids, in posts from one with a value.
struct VoidEnd {
  double solid = 1;                             ///< up to here its fill counts alone
  double fade = 0;                              ///< so much farther it fades into what lies beneath
  std::optional<double> filled = std::nullopt;  ///< beyond this it is not filled
};

/// Gives filled samples their weights, and takes those away that lie too deep in a void. `depths`: by sample
/// how many posts it lies from one with a value.
void end_voids(std::span<const double> depths, const VoidEnd& end, GroupSamples& samples);

}  // namespace cairn
