#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "builder/imagery/linear_image.h"
#include "builder/texture_encode/texture_encode.h"

namespace cairn {

/// One mip as BC1, of texels that are all opaque.
struct EncodedMip {
  int size = 0;  ///< texels along a side
  std::vector<std::byte> blocks;
  std::vector<std::uint32_t> errors;  ///< bc1_errors() of each block
};

/// Each half the size of the one before.
using EncodedMips = std::vector<EncodedMip>;

/// Encodes a square mip. None where a texel is not opaque.
std::optional<EncodedMip> encode_opaque_mip(const LinearImage& mip, TextureQuality quality);

/// encode_opaque_mip() of a tile's mip whose quarters the children's mips are, by quadrant (bit 0 east, bit 1
/// north). They have the tile's own texels but beside the two lines on which the children meet, where they
/// have what each shares with its neighbour. So only the blocks along these lines are encoded, the others
/// taken over. `mip` has the tile's texels, all opaque. The children may be null where the mip is smaller
/// than 16 texels.
EncodedMip join_mips(const std::array<const EncodedMip*, 4>& children, const LinearImage& mip,
                     TextureQuality quality);

}  // namespace cairn
