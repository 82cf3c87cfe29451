#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "format/codec.h"
#include "format/height_tile.h"
#include "format/status.h"

namespace cairn {

/// The block of a height tile: codec id, the code of the samples, and the void mask where there is one.
/// docs/pack-format.md has the byte table.
std::vector<std::byte> encode_height_block(const HeightTile& tile, const HeightCodec& codec);

/// bad_data where the bytes are no such block for tiles of this size.
Result<HeightTile> decode_height_block(std::span<const std::byte> block, int tile_size);

}  // namespace cairn
