#pragma once

// Cluster fit (Simon Brown, libsquish): the texels are put in order along an axis, and every way to cut that
// order into runs of one palette colour each is tried.

#include "builder/texture_encode/bc1_block.h"

namespace cairn::CAIRN_ISA {

// The gain of a regression on weights w is |Σ w·c|² / Σ(w − mean w)². This is the divisor's inverse for the
// weights 1, 2/3, 1/3, 0 of the texels [0,i), [i,j), [j,k), [k,16); 0 where all weights are equal.
struct GainTable {
  float factor[17][17][17];
};

constexpr GainTable make_gain_table() {
  GainTable table{};
  for (int i = 0; i <= 16; ++i) {
    for (int j = i; j <= 16; ++j) {
      for (int k = j; k <= 16; ++k) {
        // Σ(3w)² − (Σ3w)²/16, times 16 to stay whole.
        const int spread = 16 * (9 * i + 4 * (j - i) + (k - j)) - (i + j + k) * (i + j + k);
        // Among equals those are better that use both ends: the others stretch the line beyond the colours.
        const float bias = k == 16 ? 0.9999F : 1.0F;
        table.factor[i][j][k] = spread == 0 ? 0.0F : bias * 16.0F / static_cast<float>(spread);
      }
    }
  }
  return table;
}

inline constexpr GainTable kGain = make_gain_table();

// The same for the weights 1, 1/2, 0 of [0,i), [i,j), [j,16), in halves.
constexpr float three_colour_gain(int i, int j) {
  const int spread = 16 * (4 * i + (j - i)) - (i + j) * (i + j);
  return spread == 0 ? 0.0F : 16.0F / static_cast<float>(spread);
}

CAIRN_INLINE void order(I& a, I& b) {
  const I smaller = min(a, b);
  b = max(a, b);
  a = smaller;
}

// Batcher's odd-even merge sort of 16 keys.
CAIRN_INLINE void sort_16(I keys[16]) {
#pragma GCC unroll 4
  for (int p = 1; p < 16; p *= 2) {
#pragma GCC unroll 4
    for (int q = p; q >= 1; q /= 2) {
#pragma GCC unroll 16
      for (int low = 0; low < 16 - q; ++low) {
        const bool compared =
            low >= q % p && (low - q % p) / q % 2 == 0 && low / (2 * p) == (low + q) / (2 * p);
        if (compared) order(keys[low], keys[low + q]);
      }
    }
  }
}

// The texels in order along the axis.
CAIRN_INLINE void order_along(const Colours& colours, const Axis& axis, I texel[16]) {
  for (int i = 0; i < 16; ++i) {
    const F along =
        axis.r * colours.channel[0][i] + axis.g * colours.channel[1][i] + axis.b * colours.channel[2][i];
    texel[i] = (truncate(along * 65536.0F) & ~15) | i;
  }
  sort_16(texel);
  for (int i = 0; i < 16; ++i) texel[i] &= 15;
}

struct Sums {
  F channel[3][17];
};

// sums[n]: of the first n texels in order.
CAIRN_INLINE Sums running_sums(const Colours& colours, const I texel[16]) {
  Sums sums;
  for (int c = 0; c < 3; ++c) {
    sums.channel[c][0] = F{};
    for (int i = 0; i < 16; ++i)
      sums.channel[c][i + 1] = sums.channel[c][i] + pick(colours.channel[c], texel[i]);
  }
  return sums;
}

CAIRN_INLINE F squared_length(F r, F g, F b) {
  return r * r + g * g + b * b;
}

// Where the second and the third run end.
struct Split {
  I j, k;
};

// Of all ways to cut the texels in four runs, the first of them i texels long, the one that a line fits best
// before its ends are rounded. With deviations from the mean and weights in thirds, Σ w·c is a third of the
// sum of three running sums, so a way costs eleven operations.
CAIRN_INLINE Split best_split(const Sums& sums, int i) {
  F most = splat(-1.0F);
  Split split{};
  for (int j = i; j <= 16; ++j) {
    const F r = sums.channel[0][i] + sums.channel[0][j];
    const F g = sums.channel[1][i] + sums.channel[1][j];
    const F b = sums.channel[2][i] + sums.channel[2][j];
    // The lowest bits of a gain carry its k.
    F row{};
    for (int k = j; k <= 16; ++k) {
      const F gain = squared_length(r + sums.channel[0][k], g + sums.channel[1][k], b + sums.channel[2][k]);
      row = max(tagged(gain * kGain.factor[i][j][k], k), row);
    }
    const I better = row > most;
    most = max(row, most);
    split.j = select(better, splat(j), split.j);
  }
  split.k = tag_of(most);
  return split;
}

CAIRN_INLINE Weights four_colour_weights(const Sums& sums, int i) {
  const Split split = best_split(sums, i);
  const F first = splat(static_cast<float>(i)), j = to_float(split.j), k = to_float(split.k);
  Weights weights;
  weights.aa = first + (j - first) * (4 / 9.0F) + (k - j) * (1 / 9.0F);
  weights.bb = (j - first) * (1 / 9.0F) + (k - j) * (4 / 9.0F) + (16.0F - k);
  weights.ab = (k - first) * (2 / 9.0F);
  for (int c = 0; c < 3; ++c) {
    // Σ(1−t)·c is a third of this sum, and Σt·c its negative, for Σc is 0.
    const F sum = sums.channel[c][i] + pick(sums.channel[c], split.j) + pick(sums.channel[c], split.k);
    weights.products[c] = sum * (-1 / 3.0F);
  }
  return weights;
}

// The best split for each length of the first run, its ends rounded, and of those the best: rounding moves
// the error more than the choice among good splits does.
CAIRN_INLINE Ends four_colour_ends(const Colours& colours, const Sums& sums) {
  Ends best{};
  F least = splat(1e30F);
  for (int i = 0; i <= 16; ++i) {
    Ends ends{};
    const F error = fit_ends(colours, four_colour_weights(sums, i), ends);
    keep_better(ends, error < least, best);
    least = min(error, least);
  }
  return best;
}

// The ends of the best way to cut the texels in three runs.
CAIRN_INLINE Ends three_colour_ends(const Colours& colours, const Sums& sums) {
  F most = splat(-1.0F);
  I best_i{};
  for (int i = 0; i <= 16; ++i) {
    F row{};
    for (int j = i; j <= 16; ++j) {
      const F gain =
          squared_length(sums.channel[0][i] + sums.channel[0][j], sums.channel[1][i] + sums.channel[1][j],
                         sums.channel[2][i] + sums.channel[2][j]);
      row = max(tagged(gain * three_colour_gain(i, j), j), row);
    }
    const I better = row > most;
    most = max(row, most);
    best_i = select(better, splat(i), best_i);
  }
  const I best_j = tag_of(most);
  const F i = to_float(best_i), j = to_float(best_j);
  Weights weights;
  weights.ab = (j - i) * 0.25F;
  weights.aa = weights.ab + i;
  weights.bb = weights.ab + (16.0F - j);
  for (int c = 0; c < 3; ++c) {
    weights.products[c] = (pick(sums.channel[c], best_i) + pick(sums.channel[c], best_j)) * -0.5F;
  }
  Ends ends{};
  fit_ends(colours, weights, ends);
  return ends;
}

CAIRN_INLINE Sums sums_along(const Colours& colours, const Axis& axis) {
  I texel[16];
  order_along(colours, axis, texel);
  return running_sums(colours, texel);
}

}  // namespace cairn::CAIRN_ISA
