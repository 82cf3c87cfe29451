#include "builder/texture_encode/bc1_block.h"
#include "builder/texture_encode/kernel_list.h"

namespace cairn::CAIRN_ISA {

// The extent along the principal axis, then two rounds of least squares.
void encode_bc1_normal(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                       std::ptrdiff_t out_stride) {
  for (int block = 0; block < kKernelBlocks; block += kLanes) {
    Colours colours = load_colours(texels + 16 * block, stride);
    const Axis axis = principal_axis(colours, 4);
    Candidate best = nearest_positions<Errors::quick>(colours, extent_ends(colours, axis));
    refine<Errors::quick>(colours, best);
    refine<Errors::quick>(colours, best);
    const Candidate flat = one_colour(colours);
    write_blocks(select(flat.error < best.error, four_colour_code(flat), four_colour_code(best)),
                 out + block * out_stride, out_stride);
  }
}

}  // namespace cairn::CAIRN_ISA
