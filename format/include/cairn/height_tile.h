#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cairn {

/// The heights of one tile: N×N samples in quanta; metres = quanta · the pack's quantum. Row by row, columns
/// from west to east, rows from SOUTH to north. Neighbouring tiles share their edge samples.
struct HeightTile {
  int size = 0;  ///< N: 513 or 257
  std::vector<std::int32_t>
      samples;                      ///< N·N; a void sample has a smooth filler, so that codecs meet no cliff
  std::vector<std::uint8_t> voids;  ///< empty if no sample is void, else N·N of 0, or 1 for void

  std::int32_t at(int column, int row) const {
    return samples[static_cast<std::size_t>(row) * static_cast<std::size_t>(size) +
                   static_cast<std::size_t>(column)];
  }
  bool is_void(int column, int row) const {
    return !voids.empty() && voids[static_cast<std::size_t>(row) * static_cast<std::size_t>(size) +
                                   static_cast<std::size_t>(column)] != 0;
  }
};

/// The lowest and the highest sample that is not void; 0 and 0 if all are void.
struct HeightRange {
  std::int32_t lowest = 0;
  std::int32_t highest = 0;
};
HeightRange range_of(const HeightTile& tile);

}  // namespace cairn
