#include "builder/heights/downsample.h"

#include <algorithm>
#include <cmath>

#include "builder/heights/void_filler.h"

namespace cairn {

HeightTile empty_parent(int tile_size) {
  const std::size_t count = static_cast<std::size_t>(tile_size) * static_cast<std::size_t>(tile_size);
  return {tile_size, std::vector<std::int32_t>(count, 0), std::vector<std::uint8_t>(count, 1)};
}

void take_child(const HeightTile& child, int quadrant, HeightTile& parent) {
  const auto size = static_cast<std::size_t>(child.size);
  const std::size_t half = (size - 1) / 2;
  const std::size_t east = (quadrant & 1) != 0 ? half : 0;
  const std::size_t north = (quadrant & 2) != 0 ? half : 0;
  for (std::size_t row = 0; row <= half; ++row) {
    const std::size_t from = 2 * row * size;
    const std::size_t to = (north + row) * size + east;
    if (child.voids.empty()) {
      for (std::size_t c = 0; c <= half; ++c) parent.samples[to + c] = child.samples[from + 2 * c];
      std::fill_n(parent.voids.begin() + static_cast<std::ptrdiff_t>(to), half + 1, std::uint8_t{0});
      continue;
    }
    for (std::size_t c = 0; c <= half; ++c) {
      if (child.voids[from + 2 * c] != 0) continue;
      parent.samples[to + c] = child.samples[from + 2 * c];
      parent.voids[to + c] = 0;
    }
  }
}

void close_parent(HeightTile& parent) {
  if (std::find(parent.voids.begin(), parent.voids.end(), 1) == parent.voids.end()) {
    parent.voids.clear();
  } else {
    fill_void_samples(parent);
  }
}

double decimation_error(const HeightTile& tile) {
  double worst = 0;
  for (int row = 0; row < tile.size; ++row) {
    const int south = row & ~1;
    const int north = std::min(south + 2 * (row & 1), tile.size - 1);
    for (int column = 0; column < tile.size; ++column) {
      const int west = column & ~1;
      const int east = std::min(west + 2 * (column & 1), tile.size - 1);
      if (tile.is_void(column, row) || tile.is_void(west, south) || tile.is_void(east, south) ||
          tile.is_void(west, north) || tile.is_void(east, north)) {
        continue;
      }
      // In doubles: four int32 heights may not fit an int32 sum.
      const double surface = (static_cast<double>(tile.at(west, south)) + tile.at(east, south) +
                              tile.at(west, north) + tile.at(east, north)) /
                             4;
      worst = std::max(worst, std::abs(surface - tile.at(column, row)));
    }
  }
  return worst;
}

}  // namespace cairn
