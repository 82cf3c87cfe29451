#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cairn {

/// A pair of values from -127 (−1) to 127 (+1): what signed BC5 stores.
struct SignedPair {
  std::int8_t x = 0;
  std::int8_t y = 0;
};

/// BC5, also called RGTC2, signed: each 4×4 texels are two 8-byte blocks of two end points and sixteen 3-bit
/// weights (ARB_texture_compression_rgtc). The end points are the block's smallest and largest value, so a
/// value is off by a fourteenth of their distance at most. REQUIRES: size is a multiple of 4 and `texels` has
/// size·size.
void append_bc5(std::span<const SignedPair> texels, int size, std::vector<std::byte>& out);

}  // namespace cairn
