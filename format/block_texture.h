#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cairn/status.h"
#include "cairn/texture_tile.h"

namespace cairn {

// A block-compressed texture: 4×4 texels a block, blocks row by row from the north-west, each row
// ceil(width/4) blocks. The texels of a border block that lie outside the image mean nothing.
//
// The bits of BC1 and BC3: "Block Compression (Direct3D 10)", Microsoft; Khronos Data Format Specification
// 1.3, chapters 18 and 20. The bits of BC7: ARB_texture_compression_bptc.

/// 8 bytes a block for bc1 (RGB, or RGB and holes), 16 for bc3 (RGB and alpha apart) and bc7 (RGBA, eight
/// modes).
constexpr std::size_t block_bytes(TextureFormat format) {
  return format == TextureFormat::bc1 ? 8 : 16;
}

/// The bytes of a texture of this size. REQUIRES: width, height >= 1.
constexpr std::uint64_t texture_bytes(TextureFormat format, int width, int height) {
  return (static_cast<std::uint64_t>(width) + 3) / 4 * ((static_cast<std::uint64_t>(height) + 3) / 4) *
         block_bytes(format);
}

/// The 16 texels of a block, row by row, RGBA.
using BlockTexels = std::array<std::uint8_t, 64>;

/// Decodes one block; every bit pattern has a meaning. Colours between the ends are rounded to the nearest
/// 8-bit value: (2a+b+1)/3 and the like. A BC7 block of a reserved mode is transparent black.
BlockTexels decode_bc1_block(std::span<const std::byte, 8> block);
BlockTexels decode_bc3_block(std::span<const std::byte, 16> block);
BlockTexels decode_bc7_block(std::span<const std::byte, 16> block);

/// Fills `rgba` (width·height·4) from `blocks`. bad_data where `blocks` is not as long as such a texture is.
/// REQUIRES: width, height >= 1; rgba of that size.
Status decode_texture(TextureFormat format, std::span<const std::byte> blocks, int width, int height,
                      std::span<std::uint8_t> rgba);

}  // namespace cairn
