#pragma once

#include <algorithm>
#include <cstddef>

namespace cairn::wavefront {

// Thirty-two rows (a band) are decoded side by side, one a lane, each three columns behind the row below it,
// so that a lane finds the neighbours that its prediction needs already decoded. A lane that ends its row
// goes on with the row thirty-two further up.

inline constexpr int kLanes = 32;
inline constexpr int kSkew = 3;  ///< columns that a row runs behind the one below: a prediction looks 2 ahead
inline constexpr int kLeft = 3;  ///< virtual columns before a row: a prediction looks 3 back
inline constexpr int kRight = 2;                   ///< virtual columns behind a row
inline constexpr int kLag = kSkew * (kLanes - 1);  ///< steps that the last lane is behind the first

/// The places of one tile's samples. Row 0 is coded on its own; rows 1 … size-1 in bands.
struct Geometry {
  explicit Geometry(int tile_size)
      : size(tile_size),
        // The first lane must find what the last one did in the band before.
        width(std::max(tile_size + kLeft + kRight, kLag + kSkew + 1)),
        bands((tile_size - 1 + kLanes - 1) / kLanes),
        steps(bands * width + kLag) {}

  int size;   ///< samples along a side
  int width;  ///< columns with the virtual ones
  int bands;
  int steps;  ///< in each of which every lane takes one column

  /// The row of a padded plane (see below) that a tile's row is, -1 included.
  std::size_t row_start(int row) const {
    return static_cast<std::size_t>(row + 1) * static_cast<std::size_t>(width);
  }
  /// Samples in a padded plane: rows -1 … size-1, `width` columns each. A column's place is kLeft + column.
  std::size_t plane_area() const { return row_start(size); }
};

/// Where one lane is at one step.
struct Place {
  Place(const Geometry& g, int step, int lane) {
    const int travelled = step - kSkew * lane;
    if (travelled < 0) return;
    row = 1 + travelled / g.width * kLanes + lane;
    column = travelled % g.width - kLeft;
    exists = row < g.size;
    coded = exists && column >= 0 && column < g.size;
  }

  int row = 0;
  int column = 0;
  bool exists = false;  ///< in a row of the tile
  bool coded = false;   ///< and no virtual column
};

}  // namespace cairn::wavefront
