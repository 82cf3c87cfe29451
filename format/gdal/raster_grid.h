#pragma once

#include <array>
#include <optional>
#include <vector>

#include "cairn/geo.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// A layer at one level as GDAL sees it: pixels with edges, rows from the north. The value of a pixel is that
/// of the layer at the pixel's centre.
struct RasterGrid {
  double west = 0;   ///< of the outer edge, in degrees
  double north = 0;  ///< likewise
  double column_degrees = 0;
  double row_degrees = 0;
  int columns = 0;
  int rows = 0;
  int level = 0;  ///< the finest level that pixels are drawn from

  double lon_of(int column) const { return west + (column + 0.5) * column_degrees; }
  double lat_of(int row) const { return north - (row + 0.5) * row_degrees; }
  std::array<double, 6> geo_transform() const { return {west, column_degrees, 0, north, 0, -row_degrees}; }
};

/// The grid of a level over `bounds`, and after it those of coarser levels over just the same area, until one
/// has no more than 256 pixels along a side.
///
/// Heights: the pixels' centres are the samples of the level, from the last before `bounds` to the first past
/// them. Imagery: the pixels are the texels of the level, and those of the coarser grids the texels of
/// theirs. bad_data where a side has 2^31 pixels or more. REQUIRES: the pack has the layer; level is in its
/// range; bounds are not empty.
Result<std::vector<RasterGrid>> raster_grids(const PackReader& pack, Layer layer, const GeoBounds& bounds,
                                             int level);

}  // namespace cairn
