#include "builder/texture_encode/bc1_block.h"
#include "builder/texture_encode/kernel_list.h"

namespace cairn::CAIRN_ISA {

namespace {

// 1 / Σ(w − mean w)² of the weights w = 1, 2/3, 1/3, 0 of the texels [0,i), [i,j), [j,k), [k,16): the gain of
// a regression on them is this times |Σ w·c|². 0 where all weights are equal.
struct GainTable {
  float factor[17][17][17];
};

constexpr GainTable make_gain_table() {
  GainTable table{};
  for (int i = 0; i <= 16; ++i) {
    for (int j = i; j <= 16; ++j) {
      for (int k = j; k <= 16; ++k) {
        // In ninths: Σ(3w)² − (Σ3w)²/16, times 16 to stay whole.
        const int spread = 16 * (9 * i + 4 * (j - i) + (k - j)) - (i + j + k) * (i + j + k);
        table.factor[i][j][k] = spread == 0 ? 0.0F : 16.0F / static_cast<float>(spread);
      }
    }
  }
  return table;
}

constexpr GainTable kGain = make_gain_table();

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

// values[index] of each lane.
CAIRN_INLINE F pick(const F values[16], I index) {
  I lanes;
  for (int lane = 0; lane < kLanes; ++lane) lanes[lane] = lane;
  const I bits = lookup(reinterpret_cast<const std::int32_t*>(values), index * kLanes + lanes);
  return reinterpret_cast<F>(bits);
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

struct Split {
  I i, j, k;
};

// The k of the best split that begins with this i and j.
int best_k(const Sums& sums, int lane, int i, int j, int last) {
  int best = j;
  float most = -1;
  for (int k = j; k <= last; ++k) {
    float squared = 0;
    for (int c = 0; c < 3; ++c) {
      const float sum = sums.channel[c][i][lane] + sums.channel[c][j][lane] + sums.channel[c][k][lane];
      squared += sum * sum;
    }
    const float gain = squared * kGain.factor[i][j][k];
    if (gain > most) most = gain, best = k;
  }
  return best;
}

// Of all ways to cut the ordered texels in four runs, the first and the last of them not empty, the one that
// a line fits best before its ends are rounded (Simon Brown's cluster fit). With deviations from the mean and
// weights in thirds, Σ w·c is a third of the sum of three running sums, so a way costs nine operations.
CAIRN_INLINE Split best_split(const Sums& sums) {
  F most = splat(-1.0F);
  I most_ij{};
  for (int i = 1; i <= 15; ++i) {
    for (int j = i; j <= 15; ++j) {
      const F r = sums.channel[0][i] + sums.channel[0][j];
      const F g = sums.channel[1][i] + sums.channel[1][j];
      const F b = sums.channel[2][i] + sums.channel[2][j];
      F row = splat(-1.0F);
      for (int k = j; k <= 15; ++k) {
        const F all_r = r + sums.channel[0][k], all_g = g + sums.channel[1][k],
                all_b = b + sums.channel[2][k];
        row = max((all_r * all_r + all_g * all_g + all_b * all_b) * kGain.factor[i][j][k], row);
      }
      const I better = row > most;
      most = max(row, most);
      most_ij = select(better, splat(i * 17 + j), most_ij);
    }
  }
  Split split;
  for (int lane = 0; lane < kLanes; ++lane) {
    split.i[lane] = most_ij[lane] / 17;
    split.j[lane] = most_ij[lane] % 17;
    split.k[lane] = best_k(sums, lane, split.i[lane], split.j[lane], 15);
  }
  return split;
}

CAIRN_INLINE Candidate cluster_fit(const Colours& colours, const Axis& axis) {
  I texel[16];
  order_along(colours, axis, texel);
  const Split split = best_split(running_sums(colours, texel));
  F position[16];
  for (int n = 0; n < 16; ++n) {
    const I run = -(split.i <= n) - (split.j <= n) - (split.k <= n);
    for (int lane = 0; lane < kLanes; ++lane) position[texel[n][lane]][lane] = static_cast<float>(run[lane]);
  }
  return nearest_positions(colours, fit_ends(colours, position));
}

CAIRN_INLINE Axis axis_between(const Ends& ends) {
  return {ends.value[1][0] - ends.value[0][0], ends.value[1][1] - ends.value[0][1],
          ends.value[1][2] - ends.value[0][2]};
}

}  // namespace

void encode_bc1_best(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                     std::ptrdiff_t out_stride) {
  for (int block = 0; block < kKernelBlocks; block += kLanes) {
    Colours colours = load_colours(texels + 16 * block, stride);
    Candidate best = cluster_fit(colours, principal_axis(colours, 4));
    keep_better(cluster_fit(colours, axis_between(best.ends)), best);
    refine(colours, best);
    refine(colours, best);
    keep_better(one_colour(colours), best);
    write_four_colours(best, out + block * out_stride, out_stride);
  }
}

}  // namespace cairn::CAIRN_ISA
