#pragma once

#include <cstdint>
#include <vector>

#include "builder/mosaic/source_group.h"

namespace cairn {

/// Groups of sources laid over one another in a window of samples.
struct OverlaidSamples {
  std::vector<float> heights;  ///< metres, rows south to north; NaN only where the state is none
  std::vector<SampleState> states;
  /// By group of the request: its posts in the closed window. A post that lost to a group above keeps its
  /// owner and has NaN for a height; one of a projected raster lies among `lost`.
  std::vector<MeasuredPosts> posts;
  /// Where the first group of the request decides, or changes what lies beneath: 0 where it does not, else
  /// how it does.
  std::vector<std::uint8_t> touched;
};

}  // namespace cairn
