#include "builder/texture_encode/bc7_modes.h"
#include "builder/texture_encode/bc7_partition.h"
#include "builder/texture_encode/kernel_list.h"

namespace cairn::CAIRN_ISA {

namespace {

CAIRN_INLINE void try_separate_channels(const Pixels& pixels, Bc7Candidate& best) {
  for (int rotation = all_opaque(pixels) ? 1 : 0; rotation < 4; ++rotation) {
    keep_better(fit_separate_channel<Mode5Colour, Mode5Scalar>(pixels, 5, rotation, 2), best);
    keep_better(fit_separate_channel<Mode4Colour, Mode4Scalar>(pixels, 4, rotation, 2), best);
  }
}

CAIRN_INLINE void try_two_subsets(const Pixels& pixels, Bc7Candidate& best) {
  I partitions[4];
  promising_partitions<2>(pixels, 64, partitions);
  for (const I& partition : partitions) {
    keep_better(fit_subsets<Mode1Fit, 2>(pixels, 1, partition, 2), best);
    keep_better(fit_subsets<Mode3Fit, 2>(pixels, 3, partition, 2), best);
  }
}

CAIRN_INLINE void try_three_subsets(const Pixels& pixels, Bc7Candidate& best) {
  // Mode 0 has room for the first sixteen only.
  I of_16[2], of_64[2];
  promising_partitions<3>(pixels, 16, of_16);
  promising_partitions<3>(pixels, 64, of_64);
  for (const I& partition : of_16) keep_better(fit_subsets<Mode0Fit, 3>(pixels, 0, partition, 2), best);
  for (const I& partition : of_64) keep_better(fit_subsets<Mode2Fit, 3>(pixels, 2, partition, 2), best);
}

}  // namespace

// Every mode but 7 (two subsets with alpha), those with subsets with several partitions each.
void encode_bc7_best(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                     std::ptrdiff_t out_stride) {
  for (int block = 0; block < kKernelBlocks; block += kLanes) {
    const Pixels pixels = load_pixels(texels + 16 * block, stride);
    Bc7Candidate best = fit_mode6(pixels, 3);
    keep_better(fit_one_colour(pixels), best);
    try_separate_channels(pixels, best);
    try_two_subsets(pixels, best);
    try_three_subsets(pixels, best);
    write_bc7(best, out + block * out_stride, out_stride);
  }
}

}  // namespace cairn::CAIRN_ISA
