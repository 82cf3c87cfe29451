#pragma once

#include "builder/texture_encode/bc7_block.h"
#include "builder/texture_encode/bc7_pack.h"
#include "builder/texture_encode/one_colour.h"

namespace cairn::CAIRN_ISA {

CAIRN_INLINE void keep_better(const Bc7Candidate& other, Bc7Candidate& best) {
  const I better = other.error < best.error;
  best.mode = select(better, other.mode, best.mode);
  best.partition = select(better, other.partition, best.partition);
  best.rotation = select(better, other.rotation, best.rotation);
  for (int s = 0; s < 3; ++s) {
    for (int e = 0; e < 2; ++e) {
      for (int c = 0; c < 4; ++c)
        best.stored[s][e][c] = select(better, other.stored[s][e][c], best.stored[s][e][c]);
      best.p[s][e] = select(better, other.p[s][e], best.p[s][e]);
    }
  }
  for (int i = 0; i < 16; ++i) {
    best.index[i] = select(better, other.index[i], best.index[i]);
    best.second_index[i] = select(better, other.second_index[i], best.second_index[i]);
  }
  best.error = min(other.error, best.error);
}

template <class SubsetFit>
CAIRN_INLINE void add_subset(const SubsetFit& fit, int subset, Bc7Candidate& to) {
  constexpr int kChannels = sizeof(fit.stored[0]) / sizeof(I);
  for (int e = 0; e < 2; ++e) {
    for (int c = 0; c < kChannels; ++c) to.stored[subset][e][c] = fit.stored[e][c];
    to.p[subset][e] = fit.p[e];
  }
  for (int i = 0; i < 16; ++i) to.index[i] |= fit.index[i];
  to.error += fit.error;
}

CAIRN_INLINE Bc7Candidate fit_mode6(const Pixels& pixels, int rounds) {
  I all[16];
  for (I& member : all) member = splat(-1);
  Bc7Candidate found{};
  found.mode = splat(6);
  add_subset(fit_subset<Mode6Fit, 4>(pixels, all, pixels.opaque, rounds), 0, found);
  return found;
}

inline constexpr OneColourTable kOneColour7 = one_colour_table(7, share_21_of_64);

/// The whole block in the colour nearest to its mean, which mode 5 has exactly: index 1 of 7-bit ends, alpha
/// in 8.
CAIRN_INLINE Bc7Candidate fit_one_colour(const Pixels& pixels) {
  Bc7Candidate found{};
  found.mode = splat(5);
  for (int c = 0; c < 4; ++c) {
    F sum{};
    for (int i = 0; i < 16; ++i) sum += pixels.channel[c][i];
    const I value = truncate(sum * (1 / 16.0F) + 0.5F);
    const I ends = lookup(kOneColour7.ends, value);
    found.stored[0][0][c] = c == 3 ? value : ends & 255;
    found.stored[0][1][c] = c == 3 ? value : ends >> 8;
    for (int i = 0; i < 16; ++i) {
      const F off = pixels.channel[c][i] - to_float(value);
      found.error += off * off;
    }
  }
  for (I& index : found.index) index = splat(1);
  return found;
}

/// A mode of two or three subsets, without alpha. Where the block is not opaque its error is infinite.
template <class SubsetFit, int kSubsets>
CAIRN_INLINE Bc7Candidate fit_subsets(const Pixels& pixels, int mode, I partition, int rounds) {
  constexpr int kBits = kSubsets - 1;  // of a texel in the partition's pattern
  I pattern;
  for (int lane = 0; lane < kLanes; ++lane) {
    pattern[lane] = kSubsets == 2 ? bptc::kPartitions2.data()[partition[lane]]
                                  : static_cast<std::int32_t>(bptc::kPartitions3.data()[partition[lane]]);
  }
  Bc7Candidate found{};
  found.mode = splat(mode);
  found.partition = partition;
  for (int subset = 0; subset < kSubsets; ++subset) {
    I member[16];
    for (int i = 0; i < 16; ++i) member[i] = (pattern >> (kBits * i) & ((1 << kBits) - 1)) == subset;
    add_subset(fit_subset<SubsetFit, 3>(pixels, member, splat(0), rounds), subset, found);
  }
  found.error = select(pixels.opaque, found.error, splat(1e30F));
  return found;
}

/// Modes 4 and 5: one channel, or alpha where `rotation` is 0, on a line of its own.
template <class ColourFit, class ScalarFit>
CAIRN_INLINE Bc7Candidate fit_separate_channel(const Pixels& pixels, int mode, int rotation, int rounds) {
  Pixels colour = pixels, scalar;
  const int apart = rotation == 0 ? 3 : rotation - 1;
  for (int i = 0; i < 16; ++i) {
    scalar.channel[0][i] = pixels.channel[apart][i];
    colour.channel[apart][i] = pixels.channel[3][i];
  }
  I all[16];
  for (I& member : all) member = splat(-1);
  Bc7Candidate found{};
  found.mode = splat(mode);
  found.rotation = splat(rotation);
  add_subset(fit_subset<ColourFit, 3>(colour, all, splat(0), rounds), 0, found);
  const auto fit = fit_subset<ScalarFit, 1>(scalar, all, splat(0), rounds);
  for (int e = 0; e < 2; ++e) found.stored[0][e][3] = fit.stored[e][0];
  for (int i = 0; i < 16; ++i) found.second_index[i] = fit.index[i];
  found.error += fit.error;
  return found;
}

CAIRN_INLINE bool all_opaque(const Pixels& pixels) {
  bool all = true;
  for (int lane = 0; lane < kLanes; ++lane) all &= pixels.opaque[lane] != 0;
  return all;
}

CAIRN_INLINE void write_bc7(const Bc7Candidate& best, std::byte* out, std::ptrdiff_t out_stride) {
  for (int lane = 0; lane < kLanes; ++lane) pack_bc7(best, lane, out + block_of_lane(lane) * out_stride);
}

}  // namespace cairn::CAIRN_ISA
