#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace cairn {

/// Encodes a block some of whose texels (alpha < 128) are holes: BC1's mode of three colours and transparent
/// black. `texels` is 4 rows of 4 RGBA texels, `stride` bytes apart.
std::array<std::byte, 8> encode_bc1_holes(const std::uint8_t* texels, std::ptrdiff_t stride);

}  // namespace cairn
