#include "builder/texture_encode/bc7_modes.h"
#include "builder/texture_encode/kernel_list.h"

namespace cairn::CAIRN_ISA {

// Mode 6: one line of sixteen colours.
void encode_bc7_fast(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                     std::ptrdiff_t out_stride) {
  for (int block = 0; block < kKernelBlocks; block += kLanes) {
    const Pixels pixels = load_pixels(texels + 16 * block, stride);
    Bc7Candidate best = fit_mode6(pixels, 1);
    keep_better(fit_one_colour(pixels), best);
    write_bc7(best, out + block * out_stride, out_stride);
  }
}

}  // namespace cairn::CAIRN_ISA
