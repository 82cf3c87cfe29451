#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "cairn/height_tile.h"
#include "cairn/status.h"
#include "format/codec.h"

namespace cairn {

/// Returns the block of a height tile (docs/pack-format.md): codec id, void mask if any, code of the samples.
/// Equal tiles and codecs give equal bytes. A void sample's filler is coded as any other sample. A mask
/// without a void is not stored. REQUIRES: tile.voids is empty or has size·size values of 0 or 1.
std::vector<std::byte> encode_height_block(const HeightTile& tile, const HeightCodec& codec);

/// Decodes a block. The error is bad_data if it is no height block of this tile size, or if bytes are left
/// over.
Result<HeightTile> decode_height_block(std::span<const std::byte> block, int tile_size);

}  // namespace cairn
