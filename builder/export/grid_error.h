#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "builder/export/metre_tiles.h"
#include "builder/export/pack_patches.h"
#include "builder/export/vertical_shift.h"
#include "cairn/geo.h"
#include "cairn/status.h"

namespace cairn {

/// Heights on a grid of another program, as it decodes them.
struct DecodedGrid {
  int columns = 0;
  int rows = 0;
  std::vector<double> metres;  ///< row-major from the first row

  /// Bilinear. REQUIRES: 0 <= column <= columns - 1, 0 <= row <= rows - 1.
  double at(double column, double row) const;
};

/// A position between the posts of a grid.
struct GridPosition {
  double column = 0;
  double row = 0;
};

/// The ticks around bounds within -180…180 and -90…90 degrees.
TickRect ticks_around(const GeoBounds& bounds);

/// The largest distance of the grid's bilinear surface from the pack's samples of levels up to `finest`, plus
/// their tile's own error; 0 where the grid has no sample. `position` says where a place is in the grid.
/// Samples that the grid does not surround do not count.
Result<double> grid_error(const PackPatches& patches, MetreTiles& tiles, const VerticalShift& shift,
                          const TickRect& rect, int finest, const DecodedGrid& grid,
                          const std::function<GridPosition(LonLat)>& position);

}  // namespace cairn
