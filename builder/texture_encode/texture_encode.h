#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cairn/bake_choices.h"
#include "format/block_texture.h"

namespace cairn {

/// Appends the blocks of the RGBA image `rgba` (rows from the north, width·height·4 bytes) to `out`, as
/// decode_texture() reads them. Where the size is no multiple of 4, the last column and row are repeated to
/// fill the border blocks.
///
/// bc1: texels with alpha < 128 become holes (transparent black), the others opaque. bc3, bc7: alpha as
/// given. Channels weigh the same, holes nothing. The same image gives the same bytes on every x86-64 CPU.
/// REQUIRES: width, height >= 1; rgba of that size.
void encode_texture(TextureFormat format, TextureQuality quality, std::span<const std::uint8_t> rgba,
                    int width, int height, std::vector<std::byte>& out);

/// Appends to `errors`, for each BC1 block of an image, the sum of the squared differences of R, G and B
/// between its 16 texels (those that encode_texture() repeats count again) and what decode_texture() makes of
/// it, but much quicker. REQUIRES: as for encode_texture(), and blocks of that size.
void bc1_errors(std::span<const std::uint8_t> rgba, int width, int height, std::span<const std::byte> blocks,
                std::vector<std::uint32_t>& errors);

/// The instruction sets that kernels exist for, each holding those before it: SSE2; AVX2; AVX-512 F, BW, DQ
/// and VL.
enum class KernelIsa : std::uint8_t { portable, avx2, avx512 };

/// The widest that this CPU has. encode_texture() uses it where it is the fastest, too.
KernelIsa widest_kernel_isa();

/// The two with the kernels of one instruction set, for tests and benches.
/// REQUIRES: the CPU has it.
void encode_texture_with(KernelIsa isa, TextureFormat format, TextureQuality quality,
                         std::span<const std::uint8_t> rgba, int width, int height,
                         std::vector<std::byte>& out);
void bc1_errors_with(KernelIsa isa, std::span<const std::uint8_t> rgba, int width, int height,
                     std::span<const std::byte> blocks, std::vector<std::uint32_t>& errors);

}  // namespace cairn
