#include "format/rqt_steps.h"

#include <cassert>

namespace cairn {

RqtSteps::RqtSteps(int size, bool rising) : size_(size), rising_(rising) {
  assert(size >= 3 && size <= 4097 && ((size - 1) & (size - 2)) == 0);
  steps_.resize(static_cast<std::size_t>(size) * static_cast<std::size_t>(size));
  const int last = size - 1;
  for (const int row : {0, last}) {
    for (const int column : {0, last}) set(column, row, kMostRqtSteps);
  }
}

RqtNeeds rqt_needs_of(int column, int row, int size, bool rising) {
  const int last = size - 1;
  const int both = column | row;
  const int h = both & -both;  // half a side of the finest square that has the vertex
  const auto at = [size](int c, int r) {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(size) + static_cast<std::size_t>(c);
  };
  if ((column & h) != 0 && (row & h) != 0) {
    return diagonal_rises(rising, size, column - h, row - h, 2 * h)
               ? RqtNeeds{at(column + h, row - h), at(column - h, row + h)}
               : RqtNeeds{at(column - h, row - h), at(column + h, row + h)};
  }
  if ((column & h) != 0)
    return {at(column, row == 0 ? h : row - h), at(column, row == last ? row - h : row + h)};
  return {at(column == 0 ? h : column - h, row), at(column == last ? column - h : column + h, row)};
}

void RqtSteps::raise(int column, int row, int steps) {
  if (at(column, row) >= steps) return;
  set(column, row, steps);
  const RqtNeeds needs = rqt_needs_of(column, row, size_, rising_);
  for (const std::size_t need : {needs.first, needs.second})
    raise(static_cast<int>(need % static_cast<std::size_t>(size_)),
          static_cast<int>(need / static_cast<std::size_t>(size_)), steps);
}

// Two to begin with; a base inside the tile is that of two triangles, on the border of one, and each becomes
// two.
std::size_t RqtSteps::triangle_count(int k) const {
  const int last = size_ - 1;
  std::size_t count = 2;
  for (int row = 0; row <= last; ++row) {
    for (int column = 0; column <= last; ++column) {
      if (!has(column, row, k)) continue;
      const bool east_west = column == 0 || column == last, north_south = row == 0 || row == last;
      if (east_west && north_south) continue;
      count += east_west || north_south ? 1 : 2;
    }
  }
  return count;
}

}  // namespace cairn
