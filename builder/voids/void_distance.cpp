#include "builder/voids/void_distance.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace cairn {

std::vector<int> distances_to_values(const PostBlock& block, int most) {
  std::vector<int> along_rows(block.owners.size(), most);
  const auto sweep = [&](int r, int first, int step) {
    int distance = most;
    for (int c = first; c >= 0 && c < block.columns; c += step) {
      distance = PostBlock::has_value(block.owners[block.index(c, r)]) ? 0 : std::min(distance + 1, most);
      int& least = along_rows[block.index(c, r)];
      least = std::min(least, distance);
    }
  };
  for (int r = 0; r < block.rows; ++r) {
    sweep(r, 0, 1);
    sweep(r, block.columns - 1, -1);
  }
  std::vector<int> distances(along_rows);
  for (int r = 0; r < block.rows; ++r) {
    for (int other = std::max(r - most, 0); other <= std::min(r + most, block.rows - 1); ++other) {
      const int apart = std::abs(other - r);
      for (int c = 0; c < block.columns; ++c) {
        int& least = distances[block.index(c, r)];
        least = std::min(least, std::max(apart, along_rows[block.index(c, other)]));
      }
    }
  }
  return distances;
}

double distance_at(const PostBlock& block, const std::vector<int>& distances, double column, double row) {
  const auto c = static_cast<int>(std::floor(column)), r = static_cast<int>(std::floor(row));
  const double u = column - c, v = row - r;
  const int east = std::min(c + 1, block.columns - 1), north = std::min(r + 1, block.rows - 1);
  const auto at = [&](int i, int j) { return static_cast<double>(distances[block.index(i, j)]); };
  return (1 - v) * ((1 - u) * at(c, r) + u * at(east, r)) +
         v * ((1 - u) * at(c, north) + u * at(east, north));
}

}  // namespace cairn
