#include "runtime/stats/roughness.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace cairn {
namespace {

float deviation(const HeightTile& tile, int x0, int y0, int x1, int y1) {
  const double middle = tile.at((x0 + x1) / 2, (y0 + y1) / 2);
  return static_cast<float>(std::abs(middle - (static_cast<double>(tile.at(x0, y0)) + tile.at(x1, y1)) / 2));
}

float local_roughness(const HeightTile& tile, int west, int south, int width) {
  const int east = west + width, north = south + width;
  const float largest =
      std::max({deviation(tile, west, south, east, south), deviation(tile, west, north, east, north),
                deviation(tile, west, south, west, north), deviation(tile, east, south, east, north),
                deviation(tile, west, south, east, north), deviation(tile, west, north, east, south)});
  return largest / static_cast<float>(width);
}

}  // namespace

std::vector<float> roughness_of(const HeightTile& tile) {
  assert(tile.size >= 3);
  std::vector<float> values;
  std::size_t finer = 0;  // where the next finer level begins
  for (int width = 2; width < tile.size; width *= 2) {
    const int side = (tile.size - 1) / width;
    const std::size_t begin = values.size();
    for (int row = 0; row < side; ++row) {
      for (int column = 0; column < side; ++column) {
        float value = local_roughness(tile, column * width, row * width, width);
        for (int child = 0; width > 2 && child < 4; ++child) {
          const int index = (2 * row + (child >> 1)) * 2 * side + 2 * column + (child & 1);
          value = std::max(value, values[finer + static_cast<std::size_t>(index)] / 2);
        }
        values.push_back(value);
      }
    }
    finer = begin;
  }
  return values;
}

}  // namespace cairn
