#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "format/delaunay.h"

namespace cairn {

/// Stands for the height of a place that another grid has.
inline constexpr float kElsewhere = std::numeric_limits<float>::quiet_NaN();

/// Heights on a regular grid, in a mesh's own coordinates.
struct HeightSamples {
  std::int64_t column = 0;  ///< of the first sample
  std::int64_t row = 0;
  std::int64_t step = 1;  ///< from one sample to the next
  int columns = 0;
  int rows = 0;
  std::vector<float> metres;        ///< row-major, from the south-west, or kElsewhere
  std::vector<std::uint8_t> voids;  ///< 1 where the height stands for a void; empty where none does
  double error_m = 0;               ///< what the ground is off the bilinear surface of these samples

  GridPlace place(int c, int r) const { return {column + c * step, row + r * step}; }
  std::size_t index(int c, int r) const {
    return static_cast<std::size_t>(r) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(c);
  }

  /// Between the samples; NaN where one that has weight is. REQUIRES: the grid has the place, which is
  /// counted from the first sample.
  double bilinear_at(std::int64_t x, std::int64_t y) const;
};

}  // namespace cairn
