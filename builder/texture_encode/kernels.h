#pragma once

// The kernels: each is compiled once for every instruction set, and gives the same bytes in all of them.

#include <cstddef>
#include <cstdint>

namespace cairn {

/// A kernel encodes this many blocks that lie side by side.
inline constexpr int kKernelBlocks = 16;

/// Encodes kKernelBlocks blocks. `texels` is the first of 4 rows of 4·kKernelBlocks RGBA texels, `stride`
/// bytes apart. Block i is written to out + i·out_stride; a colour or alpha block is 8 bytes, a BC7 block 16.
using Kernel = void (*)(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                        std::ptrdiff_t out_stride);

/// The squared error of kKernelBlocks BC1 blocks against their texels' R, G and B; `blocks` one after the
/// other.
using ErrorKernel = void (*)(const std::uint8_t* texels, std::ptrdiff_t stride, const std::byte* blocks,
                             std::uint32_t* errors);

/// Indexed by TextureQuality.
struct KernelSet {
  Kernel colour[3];       ///< BC1 without holes
  Kernel four_colour[3];  ///< BC1 in the mode of four colours: the colour half of a BC3 block
  Kernel alpha[3];        ///< the alpha half of a BC3 block
  Kernel bc7[3];
  ErrorKernel bc1_errors;
};

namespace portable {
extern const KernelSet kernels;
}
namespace avx2 {
extern const KernelSet kernels;
}
namespace avx512 {
extern const KernelSet kernels;
}

}  // namespace cairn
