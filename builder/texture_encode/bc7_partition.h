#pragma once

#include "builder/texture_encode/bc7_block.h"

namespace cairn::CAIRN_ISA {

/// Sums over some texels of a block: r g b rr rg rb gg gb bb, of deviations from the block's mean.
struct Moments {
  F sum[9];
};

/// The squares of what a line through these texels leaves over: trace less largest eigenvalue of their
/// scatter matrix, by two steps of power iteration.
CAIRN_INLINE F left_by_line(const Moments& m, F inverse_n) {
  const F r = m.sum[0], g = m.sum[1], b = m.sum[2];
  F rr = m.sum[3] - r * r * inverse_n, gg = m.sum[6] - g * g * inverse_n, bb = m.sum[8] - b * b * inverse_n;
  F rg = m.sum[4] - r * g * inverse_n, rb = m.sum[5] - r * b * inverse_n, gb = m.sum[7] - g * b * inverse_n;
  const F trace = rr + gg + bb;
  const F scale = 1.0F / max(trace, splat(1e-3F));
  rr *= scale, gg *= scale, bb *= scale, rg *= scale, rb *= scale, gb *= scale;
  const I red_most = rr >= gg, blue_most = bb > max(rr, gg);
  F x = select(blue_most, rb, select(red_most, rr, rg));
  F y = select(blue_most, gb, select(red_most, rg, gg));
  F z = select(blue_most, bb, select(red_most, rb, gb));
  for (int step = 0; step < 2; ++step) {
    const F turned_x = rr * x + rg * y + rb * z, turned_y = rg * x + gg * y + gb * z;
    z = rb * x + gb * y + bb * z;
    x = turned_x, y = turned_y;
  }
  const F along =
      x * (rr * x + rg * y + rb * z) + y * (rg * x + gg * y + gb * z) + z * (rb * x + gb * y + bb * z);
  const F squared = x * x + y * y + z * z;
  return trace * max(1.0F - along / max(squared, splat(1e-30F)), splat(0.0F));
}

/// What makes up the moments, texel by texel, and their sum over the block.
struct MomentTerms {
  F term[9][16];
  Moments all;
};

CAIRN_INLINE MomentTerms moment_terms(const Pixels& pixels) {
  MomentTerms terms;
  F mean[3] = {};
  for (int c = 0; c < 3; ++c) {
    for (int i = 0; i < 16; ++i) mean[c] += pixels.channel[c][i];
    mean[c] *= 1 / 16.0F;
  }
  terms.all = {};
  for (int i = 0; i < 16; ++i) {
    const F r = pixels.channel[0][i] - mean[0], g = pixels.channel[1][i] - mean[1],
            b = pixels.channel[2][i] - mean[2];
    const F values[9] = {r, g, b, r * r, r * g, r * b, g * g, g * b, b * b};
    for (int k = 0; k < 9; ++k) {
      terms.term[k][i] = values[k];
      terms.all.sum[k] += values[k];
    }
  }
  return terms;
}

/// What lines leave over, one through each subset.
template <int kSubsets>
CAIRN_INLINE F left_by_partition(const MomentTerms& terms, int partition) {
  Moments part[kSubsets] = {};
  int count[kSubsets] = {16};
  part[0] = terms.all;
  for (int i = 0; i < 16; ++i) {
    const unsigned subset = kSubsets == 2 ? bptc::kPartitions2.data()[partition] >> i & 1U
                                          : bptc::kPartitions3.data()[partition] >> (2 * i) & 3U;
    if (subset == 0) continue;
    ++count[subset];
    --count[0];
    for (int k = 0; k < 9; ++k) part[subset].sum[k] += terms.term[k][i];
  }
  for (int s = 1; s < kSubsets; ++s) {
    for (int k = 0; k < 9; ++k) part[0].sum[k] -= part[s].sum[k];
  }
  F left{};
  for (int s = 0; s < kSubsets; ++s)
    left += left_by_line(part[s], splat(1.0F / static_cast<float>(count[s])));
  return left;
}

/// Of the first `total` partitions those whose subsets lie nearest to lines, best first.
template <int kSubsets, int kCount>
CAIRN_INLINE void promising_partitions(const Pixels& pixels, int total, I (&partitions)[kCount]) {
  const MomentTerms terms = moment_terms(pixels);
  F least[kCount];
  for (F& each : least) each = splat(1e30F);
  for (I& partition : partitions) partition = splat(0);
  for (int number = 0; number < total; ++number) {
    F left = left_by_partition<kSubsets>(terms, number);
    I which = splat(number);
    for (int place = 0; place < kCount; ++place) {
      const I better = left < least[place];
      const F was = least[place];
      const I was_which = partitions[place];
      least[place] = min(left, was);
      partitions[place] = select(better, which, was_which);
      left = select(better, was, left);
      which = select(better, was_which, which);
    }
  }
}

}  // namespace cairn::CAIRN_ISA
