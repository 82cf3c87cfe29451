#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cairn/geo.h"
#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// A picture of a pack's imagery: RGBA, rows from NORTH to south, alpha not premultiplied.
struct ImageryView {
  int size = 0;  ///< pixels a side
  std::vector<std::uint8_t> rgba;
  bool is_empty = true;  ///< no pixel has a colour
};

/// Draws the bounds with so many pixels a side, from the level whose texels are the next finer than pixels:
/// the nearest texel, of a coarser tile where the level has none. REQUIRES: the pack has imagery; bounds
/// within the world.
Result<ImageryView> draw_imagery(const PackReader& pack, const GeoBounds& bounds, int size);

/// The picture as a JPEG of quality 90; what is transparent becomes white.
Result<std::vector<std::byte>> encode_jpeg(const ImageryView& view);

}  // namespace cairn
