#include "builder/texture_encode/bc1_block.h"
#include "builder/texture_encode/kernel_list.h"

namespace cairn::CAIRN_ISA {

namespace {

CAIRN_INLINE F nearest_of_four(F along) {
  return round(clamp(along, 0, 3));
}

/// Of the positions nearest to the texels on the extent of the colours along the axis, drawn in by 1/16 of
/// itself at both ends.
CAIRN_INLINE PositionSums sums_on_extent(const Colours& colours, const Axis& axis) {
  F along[16];
  F low = splat(1e9F), high = splat(-1e9F);
  for (int i = 0; i < 16; ++i) {
    along[i] =
        axis.r * colours.channel[0][i] + axis.g * colours.channel[1][i] + axis.b * colours.channel[2][i];
    low = min(low, along[i]);
    high = max(high, along[i]);
  }
  const F extent = high - low;
  const F scale = (3 * 8 / 7.0F) / max(extent, splat(1e-6F));
  const F first = -(low + extent * (1 / 16.0F)) * scale;
  PositionSums sums{};
  for (int i = 0; i < 16; ++i) add_position(colours, i, nearest_of_four(along[i] * scale + first), sums);
  return sums;
}

/// Of the positions nearest to the texels on the line that fits others best, its ends not rounded.
CAIRN_INLINE PositionSums sums_on_fit(const Colours& colours, const PositionSums& old) {
  const F mean = old.sum * (1 / 16.0F);
  const F squares = old.products[0] * old.products[0] + old.products[1] * old.products[1] +
                    old.products[2] * old.products[2];
  const F scale = (old.squares - old.sum * mean) / max(squares, splat(1e-6F));
  F step[3];
  for (int c = 0; c < 3; ++c) step[c] = old.products[c] * scale;
  PositionSums sums{};
  for (int i = 0; i < 16; ++i) {
    const F along = colours.channel[0][i] * step[0] + colours.channel[1][i] * step[1] +
                    (colours.channel[2][i] * step[2] + mean);
    add_position(colours, i, nearest_of_four(along), sums);
  }
  return sums;
}

}  // namespace

// The extent along the principal axis, then two rounds of least squares, of which the last rounds the ends.
void encode_bc1_normal(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                       std::ptrdiff_t out_stride) {
  for (int block = 0; block < kKernelBlocks; block += kLanes) {
    Colours colours = load_colours(texels + 16 * block, stride);
    const PositionSums first = sums_on_extent(colours, principal_axis(colours, 4));
    Ends ends;
    fit_ends(colours, weights_of(sums_on_fit(colours, first)), ends);
    const Candidate best = nearest_positions<Errors::quick>(colours, ends);
    const Candidate flat = one_colour(colours);
    write_blocks(select(flat.error < best.error, four_colour_code(flat), four_colour_code(best)),
                 out + block * out_stride, out_stride);
  }
}

}  // namespace cairn::CAIRN_ISA
