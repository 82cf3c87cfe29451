#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "builder/export/height_samples.h"

namespace cairn {

/// Which of many grids may have a sample in a rectangle. One thread asks at a time.
class GridIndex {
 public:
  /// REQUIRES: the grids outlive this and lie between 0 and `side`.
  GridIndex(std::span<const HeightSamples> grids, std::int64_t side);

  /// Returns their numbers, ascending. Valid until the next call.
  const std::vector<std::uint32_t>& over(double west, double south, double east, double north);

 private:
  static constexpr int kCells = 32;
  int cell(double at) const;

  double cell_side_;
  std::size_t grids_;
  std::vector<std::vector<std::uint32_t>> cells_;  // empty where there are so few grids that all are asked
  std::vector<std::uint32_t> found_;
};

}  // namespace cairn
