#include "builder/heights/void_filler.h"

#include <algorithm>

namespace cairn {

void fill_void_samples(HeightTile& tile) {
  const auto size = static_cast<std::size_t>(tile.size);
  const auto first = std::find(tile.voids.begin(), tile.voids.end(), 0);
  if (first == tile.voids.end()) {
    std::fill(tile.samples.begin(), tile.samples.end(), 0);
    return;
  }
  std::int32_t last = tile.samples[static_cast<std::size_t>(first - tile.voids.begin())];
  for (std::size_t row = 0; row < size; ++row) {
    const auto begin = tile.voids.begin() + static_cast<std::ptrdiff_t>(row * size);
    const auto start = std::find(begin, begin + tile.size, 0);
    if (start != begin + tile.size) last = tile.samples[static_cast<std::size_t>(start - tile.voids.begin())];
    for (std::size_t i = row * size; i < (row + 1) * size; ++i) {
      if (tile.voids[i] != 0) {
        tile.samples[i] = last;
      } else {
        last = tile.samples[i];
      }
    }
  }
}

}  // namespace cairn
