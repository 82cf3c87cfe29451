#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cairn/status.h"

namespace cairn {

/// Block compression that GPUs read: 4×4 texels in 8 bytes (BC1) or 16 (BC3, BC7). The numbers identify the
/// formats in a pack.
enum class TextureFormat : std::uint8_t { bc1 = 1, bc3 = 3, bc7 = 7 };

/// The imagery of one tile in sRGB, compressed, with its full mip chain. Rows run from NORTH to south, as in
/// a DDS file; those of heights run from south to north.
struct TextureTile {
  TextureFormat format = TextureFormat::bc1;
  int size = 0;                   ///< texels along a side: 512 or 256
  std::vector<std::byte> texels;  ///< mip 0 (size×size) first, down to 1×1, as a DDS file stores them
};

/// Returns the bytes of a square image of `size` texels, at least one block; and of the chain from `size`
/// to 1.
std::size_t texture_image_bytes(TextureFormat format, int size);
std::size_t texture_chain_bytes(TextureFormat format, int size);

/// Returns the block of a texture tile (docs/pack-format.md). Equal tiles give equal bytes.
/// REQUIRES: texels.size() == texture_chain_bytes(format, size).
std::vector<std::byte> encode_texture_block(const TextureTile& tile);

/// Decodes a block. The error is bad_data if it is no texture block of this size, or if bytes are left over.
Result<TextureTile> decode_texture_block(std::span<const std::byte> block, int size);

}  // namespace cairn
