#include "cairn/height_tile.h"

#include <algorithm>
#include <limits>

#include "format/simd_clones.h"

namespace cairn {

namespace {

CAIRN_SIMD_CLONES HeightRange range_of_all(const std::int32_t* samples, std::size_t count) {
  std::int32_t lowest = std::numeric_limits<std::int32_t>::max();
  std::int32_t highest = std::numeric_limits<std::int32_t>::min();
  for (std::size_t i = 0; i < count; ++i) {
    const std::int32_t sample = samples[i];
    lowest = sample < lowest ? sample : lowest;
    highest = sample > highest ? sample : highest;
  }
  return {lowest, highest};
}

}  // namespace

HeightRange range_of(const HeightTile& tile) {
  if (tile.voids.empty()) return range_of_all(tile.samples.data(), tile.samples.size());
  HeightRange range{std::numeric_limits<std::int32_t>::max(), std::numeric_limits<std::int32_t>::min()};
  for (std::size_t i = 0; i < tile.samples.size(); ++i) {
    if (tile.voids[i] != 0) continue;
    range.lowest = std::min(range.lowest, tile.samples[i]);
    range.highest = std::max(range.highest, tile.samples[i]);
  }
  return range.lowest <= range.highest ? range : HeightRange{};
}

}  // namespace cairn
