#include "builder/texture_encode/bc7_modes.h"
#include "builder/texture_encode/bc7_partition.h"
#include "builder/texture_encode/kernel_list.h"

namespace cairn::CAIRN_ISA {

// Mode 6; mode 5, each channel apart in turn; mode 1 with the two partitions that promise most, mode 3 with
// the first.
void encode_bc7_normal(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                       std::ptrdiff_t out_stride) {
  for (int block = 0; block < kKernelBlocks; block += kLanes) {
    const Pixels pixels = load_pixels(texels + 16 * block, stride);
    Bc7Candidate best = fit_mode6(pixels, 2);
    keep_better(fit_one_colour(pixels), best);
    for (int rotation = all_opaque(pixels) ? 1 : 0; rotation < 4; ++rotation) {
      keep_better(fit_separate_channel<Mode5Colour, Mode5Scalar>(pixels, 5, rotation, 1), best);
    }
    I partitions[2];
    promising_partitions<2>(pixels, 64, partitions);
    for (const I& partition : partitions)
      keep_better(fit_subsets<Mode1Fit, 2>(pixels, 1, partition, 1), best);
    keep_better(fit_subsets<Mode3Fit, 2>(pixels, 3, partitions[0], 1), best);
    write_bc7(best, out + block * out_stride, out_stride);
  }
}

}  // namespace cairn::CAIRN_ISA
