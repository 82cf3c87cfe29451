#pragma once

#include <cstddef>
#include <cstdint>

#include "cairn/tile_id.h"

namespace cairn {

/// A rectangle of samples of the world grid: sample (k, m) lies at lon = k / samples_per_degree - 180,
/// lat = m / samples_per_degree - 90.
struct SampleWindow {
  std::int64_t column = 0;
  std::int64_t row = 0;
  int columns = 0;
  int rows = 0;
  double samples_per_degree = 1;

  std::size_t count() const { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  double lon_of(int c) const { return static_cast<double>(column + c) / samples_per_degree - 180.0; }
  double lat_of(int r) const { return static_cast<double>(row + r) / samples_per_degree - 90.0; }
};

/// The samples of a tile, its shared edges included.
inline SampleWindow window_of(const TileId& id, int tile_size) {
  const std::int64_t intervals = tile_size - 1;
  return {id.x * intervals, id.y * intervals, tile_size, tile_size,
          static_cast<double>(intervals) / tile_width_degrees(id.level)};
}

/// Where a sample's height comes from.
enum class SampleState : std::uint8_t {
  none = 0,     ///< no source reaches here
  filled = 1,   ///< inside a source, but all posts around it are void
  sourced = 2,  ///< at least one of the posts around it has a value
};

}  // namespace cairn
