#include "builder/texture_encode/bc7_modes.h"
#include "builder/texture_encode/bc7_partition.h"
#include "builder/texture_encode/kernel_list.h"

namespace cairn::CAIRN_ISA {

// Mode 6; modes 1 and 3 with the six partitions that promise most.
void encode_bc7_best(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                     std::ptrdiff_t out_stride) {
  for (int block = 0; block < kKernelBlocks; block += kLanes) {
    const Pixels pixels = load_pixels(texels + 16 * block, stride);
    Bc7Candidate best = fit_mode6(pixels, 4);
    keep_better(fit_one_colour(pixels), best);
    I partitions[6];
    promising_partitions(pixels, partitions);
    for (const I& partition : partitions) {
      keep_better(fit_two_subsets<Mode1Fit>(pixels, 1, partition, 3), best);
      keep_better(fit_two_subsets<Mode3Fit>(pixels, 3, partition, 3), best);
    }
    write_bc7(best, out + block * out_stride, out_stride);
  }
}

}  // namespace cairn::CAIRN_ISA
