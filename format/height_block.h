#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "format/codec.h"
#include "cairn/height_tile.h"
#include "cairn/status.h"

namespace cairn {

/// The block of a height tile: codec id, the void mask where some sample is void, and the code of the
/// samples. docs/pack-format.md has the byte table. The same tile and codec give the same bytes; what a void
/// sample holds is coded like any other sample and comes back as it was. A mask without a void is not stored.
/// REQUIRES: tile.voids is empty or holds size·size of 0 or 1.
std::vector<std::byte> encode_height_block(const HeightTile& tile, const HeightCodec& codec);

/// bad_data where the bytes are no such block for tiles of this size, or where bytes are left over.
Result<HeightTile> decode_height_block(std::span<const std::byte> block, int tile_size);

}  // namespace cairn
