#include "builder/texture_encode/bc1_cluster.h"
#include "builder/texture_encode/kernel_list.h"

namespace cairn::CAIRN_ISA {

namespace {

// An end's component, moved by so many steps of its 5 or 6 bits.
struct Nudge {
  int end, channel, by;
};

// Applies both nudges where that lessens the error.
CAIRN_INLINE void try_nudges(const Colours& colours, const Nudge (&nudges)[2], Candidate& best) {
  Ends ends = best.ends;
  for (const auto& [end, channel, by] : nudges) {
    const I moved = ends.stored[end][channel] + by;
    ends.stored[end][channel] = min(max(moved, splat(0)), splat((1 << kChannelBits[channel]) - 1));
    ends.value[end][channel] = to_float(widen(ends.stored[end][channel], channel));
  }
  const F error = least_error(colours, ends.value);
  keep_better(ends, error < best.error, best.ends);
  best.error = min(error, best.error);
}

// Each component up and down, alone and together with the other end's.
CAIRN_INLINE void nudge(const Colours& colours, Candidate& best) {
  for (int c = 0; c < 3; ++c) {
    for (int by = -1; by <= 1; by += 2) {
      try_nudges(colours, {{0, c, by}, {0, c, 0}}, best);
      try_nudges(colours, {{1, c, by}, {1, c, 0}}, best);
      try_nudges(colours, {{0, c, by}, {1, c, by}}, best);
      try_nudges(colours, {{0, c, by}, {1, c, -by}}, best);
    }
  }
}

CAIRN_INLINE Candidate best_four_colours(const Colours& colours, const Sums& sums) {
  Candidate best = nearest_positions<Errors::exact>(colours, four_colour_ends(colours, sums));
  refine<Errors::exact>(colours, best);
  Candidate nudged = best;
  nudge(colours, nudged);
  keep_better(nearest_positions<Errors::exact>(colours, nudged.ends), best);
  keep_better(one_colour(colours), best);
  return best;
}

CAIRN_INLINE Candidate best_three_colours(const Colours& colours, const Sums& sums) {
  Candidate best = nearest_positions<Errors::exact>(colours, three_colour_ends(colours, sums), 2);
  refine<Errors::exact>(colours, best, 2);
  return best;
}

}  // namespace

void encode_bc1_best(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                     std::ptrdiff_t out_stride) {
  for (int block = 0; block < kKernelBlocks; block += kLanes) {
    Colours colours = load_colours(texels + 16 * block, stride);
    const Sums sums = sums_along(colours, principal_axis(colours, 4));
    const Candidate four = best_four_colours(colours, sums);
    const Candidate three = best_three_colours(colours, sums);
    write_blocks(select(three.error < four.error, three_colour_code(three), four_colour_code(four)),
                 out + block * out_stride, out_stride);
  }
}

void encode_bc1_best_four(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                          std::ptrdiff_t out_stride) {
  for (int block = 0; block < kKernelBlocks; block += kLanes) {
    Colours colours = load_colours(texels + 16 * block, stride);
    const Sums sums = sums_along(colours, principal_axis(colours, 4));
    write_blocks(four_colour_code(best_four_colours(colours, sums)), out + block * out_stride, out_stride);
  }
}

}  // namespace cairn::CAIRN_ISA
