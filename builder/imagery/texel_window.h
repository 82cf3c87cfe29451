#pragma once

#include <cstdint>

#include "cairn/tile_id.h"

namespace cairn {

/// A rectangle of texels of the world grid. Texels are areas: the centre of texel (column, row) lies at
/// lon = (column + 0.5) / texels_per_degree - 180, lat = 90 - (row + 0.5) / texels_per_degree.
struct TexelWindow {
  std::int64_t column = 0;
  std::int64_t row = 0;  ///< from the North Pole
  int columns = 0;
  int rows = 0;
  double texels_per_degree = 1;

  double lon_of(double c) const {
    return (static_cast<double>(column) + c + 0.5) / texels_per_degree - 180.0;
  }
  double lat_of(double r) const { return 90.0 - (static_cast<double>(row) + r + 0.5) / texels_per_degree; }
  GeoBounds bounds() const { return {lon_of(-0.5), lat_of(rows - 0.5), lon_of(columns - 0.5), lat_of(-0.5)}; }
};

/// The texels of a tile of `size` texels a side, and `margin` more on each side.
inline TexelWindow texels_of(const TileId& id, int size, int margin) {
  const double per_degree = static_cast<double>(size) / tile_width_degrees(id.level);
  const auto pole = static_cast<std::int64_t>(180.0 * per_degree);  // whole at every level: size >= 256
  return {std::int64_t{id.x} * size - margin, pole - (std::int64_t{id.y} + 1) * size - margin,
          size + 2 * margin, size + 2 * margin, per_degree};
}

}  // namespace cairn
