#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "cairn/status.h"
#include "cairn/texture_tile.h"

namespace cairn {

// A block-compressed texture has blocks of 4×4 texels, row by row from the north-west, ceil(width/4) blocks
// in each row. The texels of a border block that lie outside the image have no meaning.
//
// The bits of BC1 and BC3: "Block Compression (Direct3D 10)", Microsoft; Khronos Data Format Specification
// 1.3, chapters 18 and 20. The bits of BC7: ARB_texture_compression_bptc.

/// Returns the bytes per block: 8 for bc1 (RGB, or RGB with holes), 16 for bc3 (RGB, and alpha apart) and bc7
/// (RGBA, eight modes).
constexpr std::size_t block_bytes(TextureFormat format) {
  return format == TextureFormat::bc1 ? 8 : 16;
}

/// Returns the bytes of a texture of this size. REQUIRES: width, height >= 1.
constexpr std::uint64_t texture_bytes(TextureFormat format, int width, int height) {
  return (static_cast<std::uint64_t>(width) + 3) / 4 * ((static_cast<std::uint64_t>(height) + 3) / 4) *
         block_bytes(format);
}

/// The 16 texels of a block, row by row, RGBA.
using BlockTexels = std::array<std::uint8_t, 64>;

/// Decodes one block; every bit pattern is valid. Colours between the ends are rounded to the nearest 8-bit
/// value, as in (2a+b+1)/3. A BC7 block of a reserved mode is transparent black.
BlockTexels decode_bc1_block(std::span<const std::byte, 8> block);
BlockTexels decode_bc3_block(std::span<const std::byte, 16> block);
BlockTexels decode_bc7_block(std::span<const std::byte, 16> block);

/// Decodes a texture into `rgba`, of width·height·4 bytes. The error is bad_data if `blocks` has not
/// texture_bytes(). REQUIRES: width, height >= 1; rgba has that size.
Status decode_texture(TextureFormat format, std::span<const std::byte> blocks, int width, int height,
                      std::span<std::uint8_t> rgba);

}  // namespace cairn
