#pragma once

#include <cstddef>
#include <cstdint>

#include "builder/imagery/uninitialized_vector.h"
#include "builder/raster/raster_source.h"
#include "cairn/status.h"

namespace cairn {

/// A rectangle of pixels, RGBA. It may reach past the raster, whose border pixels go on there.
struct PixelBlock {
  std::int64_t column = 0;
  std::int64_t row = 0;
  std::int64_t columns = 0;
  std::int64_t rows = 0;
  UninitializedVector<std::uint8_t> rgba;

  /// REQUIRES: the pixel lies in the block.
  const std::uint8_t* at(std::int64_t c, std::int64_t r) const {
    return rgba.data() + 4 * ((r - row) * columns + (c - column));
  }
};

/// Whether no pixel has any transparency.
bool is_opaque(const PixelBlock& block);

/// Whether the raster's columns go once around the Earth, so that the first follows the last.
bool goes_around(const RasterInfo& info);

/// Reads a block; columns wrap where the raster goes around the Earth. REQUIRES: it overlaps the raster.
Result<PixelBlock> read_block(const RasterSource& source, const PostWindow& window);

}  // namespace cairn
