#pragma once

#include <cstdint>
#include <vector>

#include "cairn/pack_reader.h"
#include "cairn/status.h"

namespace cairn {

/// Reads a tile of the imagery layer and decodes its finest mip: RGBA bytes in sRGB, tile_size - 1 texels
/// along a side, rows from NORTH to south. A constant tile is its colour all over.
Result<std::vector<std::uint8_t>> read_imagery_tile(const PackReader& pack, const IndexEntry& entry);

}  // namespace cairn
