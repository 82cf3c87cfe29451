#pragma once

// The steps that the BC7 kernels are made of. In every lane, one block.
//
// A subset's colours are drawn from a line between two ends at weights w/64; which weights, how fine the ends
// and how they share their lowest bits ("p") is the mode's. Field order and tables: format/bptc.h.

#include "builder/texture_encode/simd.h"
#include "format/bptc.h"

namespace cairn::CAIRN_ISA {

/// 16 texels, 0..255.
struct Pixels {
  F channel[4][16];
  I opaque;  ///< mask: every alpha is 255
};

CAIRN_INLINE Pixels load_pixels(const std::uint8_t* texels, std::ptrdiff_t stride) {
  I packed[16];
  load_texels(texels, stride, packed);
  Pixels pixels;
  I all = splat(-1);
  for (int i = 0; i < 16; ++i) {
    all &= packed[i];
    for (int c = 0; c < 4; ++c) pixels.channel[c][i] = to_float(packed[i] >> (8 * c) & 255);
  }
  pixels.opaque = alpha(all) == 255;
  return pixels;
}

/// An encoding of the block, all modes alike; docs: Table M.
struct Bc7Candidate {
  I mode, partition, rotation;
  I stored[3][2][4];  ///< [subset][end][channel], without p
  I p[3][2];          ///< of each end; the same for both where the mode shares it
  I index[16];
  I second_index[16];  ///< modes 4 and 5
  F error;
};

/// What a mode does to the ends of a subset.
enum class PBits { none, each_end, shared };

template <int kIndexBits, int kColourBits, PBits kP, int kChannels>
struct Fit {
  static constexpr int kLevels = 1 << kIndexBits;
  static constexpr int kPBits = kP == PBits::none ? 0 : 1;
  static constexpr int kWidth = kColourBits + kPBits;

  I stored[2][kChannels];
  I p[2];
  F value[2][kChannels];  // 0..255
  I index[16];            // of the texels of the subset, 0 elsewhere
  F error;

  CAIRN_INLINE static F widen(F code) {
    if constexpr (kWidth == 8) return code;
    const I x = truncate(code);
    return to_float(x << (8 - kWidth) | x >> (2 * kWidth - 8));
  }

  /// The nearest code with this p; the sum of the squared errors is returned.
  CAIRN_INLINE F quantise_end(const F* wanted, int end, int with_p) {
    F squares{};
    for (int c = 0; c < kChannels; ++c) {
      constexpr float kMost = static_cast<float>((1 << kWidth) - 1);
      const F exact = clamp(wanted[c], 0, 255) * (kMost / 255);
      F code;
      if constexpr (kPBits == 1) {
        const float odd = static_cast<float>(with_p);
        const F half = round(clamp((exact - odd) * 0.5F, 0, static_cast<float>((1 << kColourBits) - 1)));
        stored[end][c] = truncate(half);
        code = half + half + odd;
      } else {
        code = round(exact);
        stored[end][c] = truncate(code);
      }
      value[end][c] = widen(code);
      const F off = value[end][c] - wanted[c];
      squares += off * off;
    }
    p[end] = splat(with_p);
    return squares;
  }

  CAIRN_INLINE void take_end(const Fit& other, I mask, int end) {
    for (int c = 0; c < kChannels; ++c) {
      stored[end][c] = select(mask, other.stored[end][c], stored[end][c]);
      value[end][c] = select(mask, other.value[end][c], value[end][c]);
    }
    p[end] = select(mask, other.p[end], p[end]);
  }

  /// The ends nearest to the wanted ones. Where `odd_only`, p is 1: alpha 255 needs it.
  CAIRN_INLINE void quantise(const F wanted[2][4], I odd_only) {
    if constexpr (kP == PBits::none) {
      for (int end = 0; end < 2; ++end) quantise_end(wanted[end], end, 0);
    } else {
      Fit even;
      F lost[2], lost_even[2];
      for (int end = 0; end < 2; ++end) {
        lost[end] = quantise_end(wanted[end], end, 1);
        lost_even[end] = even.quantise_end(wanted[end], end, 0);
      }
      if constexpr (kP == PBits::shared) lost[0] = lost[1] = lost[0] + lost[1];
      if constexpr (kP == PBits::shared) lost_even[0] = lost_even[1] = lost_even[0] + lost_even[1];
      for (int end = 0; end < 2; ++end) take_end(even, (lost_even[end] < lost[end]) & ~odd_only, end);
    }
  }

  /// The share of end 1, in 0..1, that an index stands for.
  CAIRN_INLINE static F weight_of(F index) {
    constexpr float kLast = static_cast<float>(kLevels - 1);
    const F in_64ths =
        to_float(truncate(index * (64 / kLast) + (static_cast<float>((kLevels - 1) / 2) / kLast + 0.01F)));
    return in_64ths * (1 / 64.0F);
  }

  /// Gives every texel of the subset the nearest colour of the line.
  CAIRN_INLINE void assign(const Pixels& pixels, const I member[16]) {
    F step[kChannels], squared{};
    for (int c = 0; c < kChannels; ++c) {
      step[c] = value[1][c] - value[0][c];
      squared += step[c] * step[c];
    }
    constexpr float kLast = static_cast<float>(kLevels - 1);
    const F scale = kLast / max(squared, splat(1.0F));
    error = F{};
    for (int i = 0; i < 16; ++i) {
      F along{};
      for (int c = 0; c < kChannels; ++c) along += (pixels.channel[c][i] - value[0][c]) * step[c];
      const F nearest = round(clamp(along * scale, 0, kLast));
      const F weight = weight_of(nearest);
      F squares{};
      for (int c = 0; c < kChannels; ++c) {
        const F off = value[0][c] + weight * step[c] - pixels.channel[c][i];
        squares += off * off;
      }
      error += reinterpret_cast<F>(reinterpret_cast<I>(squares) & member[i]);
      index[i] = truncate(nearest) & member[i];
    }
  }

  /// Least squares: the ends that suit the indices best.
  CAIRN_INLINE void wanted_ends(const Pixels& pixels, const I member[16], F wanted[2][4]) const {
    F n{}, t{}, tt{}, sum[kChannels] = {}, products[kChannels] = {};
    for (int i = 0; i < 16; ++i) {
      const F one = reinterpret_cast<F>(reinterpret_cast<I>(splat(1.0F)) & member[i]);
      const F weight = weight_of(to_float(index[i])) * one;
      n += one;
      t += weight;
      tt += weight * weight;
      for (int c = 0; c < kChannels; ++c) {
        sum[c] += one * pixels.channel[c][i];
        products[c] += weight * pixels.channel[c][i];
      }
    }
    const F spread = n * tt - t * t;
    const F inverse = 1.0F / max(spread, splat(1e-3F));
    const F inverse_n = 1.0F / max(n, splat(1.0F));
    for (int c = 0; c < kChannels; ++c) {
      const F slope = select(spread > 1e-3F, (n * products[c] - t * sum[c]) * inverse, F{});
      wanted[0][c] = (sum[c] - slope * t) * inverse_n;
      wanted[1][c] = wanted[0][c] + slope;
    }
  }

  CAIRN_INLINE void refine(const Pixels& pixels, const I member[16], I odd_only) {
    F wanted[2][4];
    wanted_ends(pixels, member, wanted);
    Fit other;
    other.quantise(wanted, odd_only);
    other.assign(pixels, member);
    const I better = other.error < error;
    for (int end = 0; end < 2; ++end) take_end(other, better, end);
    for (int i = 0; i < 16; ++i) index[i] = select(better, other.index[i], index[i]);
    error = min(other.error, error);
  }
};

/// The extent of a subset's texels along their principal axis.
template <int kChannels>
CAIRN_INLINE void principal_ends(const Pixels& pixels, const I member[16], int iterations, F wanted[2][4]) {
  F n{}, mean[kChannels] = {};
  for (int i = 0; i < 16; ++i) {
    n += reinterpret_cast<F>(reinterpret_cast<I>(splat(1.0F)) & member[i]);
    for (int c = 0; c < kChannels; ++c) {
      mean[c] += reinterpret_cast<F>(reinterpret_cast<I>(pixels.channel[c][i]) & member[i]);
    }
  }
  const F inverse_n = 1.0F / max(n, splat(1.0F));
  for (F& m : mean) m *= inverse_n;

  F deviation[kChannels][16], covariance[kChannels][kChannels] = {};
  for (int i = 0; i < 16; ++i) {
    for (int c = 0; c < kChannels; ++c) {
      const F off = pixels.channel[c][i] - mean[c];
      deviation[c][i] = reinterpret_cast<F>(reinterpret_cast<I>(off) & member[i]);
    }
    for (int c = 0; c < kChannels; ++c) {
      for (int d = c; d < kChannels; ++d) covariance[c][d] += deviation[c][i] * deviation[d][i];
    }
  }
  // The row of the channel that varies most is never orthogonal to the axis.
  F axis[kChannels], most = splat(-1.0F);
  for (int c = 0; c < kChannels; ++c) {
    for (int d = 0; d < c; ++d) covariance[c][d] = covariance[d][c];
    const I more = covariance[c][c] > most;
    most = max(covariance[c][c], most);
    for (int d = 0; d < kChannels; ++d) axis[d] = select(more, covariance[c][d], c == 0 ? F{} : axis[d]);
  }
  for (int round_number = 0; round_number < iterations; ++round_number) {
    F turned[kChannels] = {}, largest = splat(1e-20F);
    for (int c = 0; c < kChannels; ++c) {
      for (int d = 0; d < kChannels; ++d) turned[c] += covariance[c][d] * axis[d];
      largest = max(max(turned[c], -turned[c]), largest);
    }
    const F scale = 1.0F / largest;
    for (int c = 0; c < kChannels; ++c) axis[c] = turned[c] * scale;
  }

  F low{}, high{}, squared{};
  for (int i = 0; i < 16; ++i) {
    F along{};
    for (int c = 0; c < kChannels; ++c) along += deviation[c][i] * axis[c];
    low = min(low, along);
    high = max(high, along);
  }
  for (int c = 0; c < kChannels; ++c) squared += axis[c] * axis[c];
  const F scale = 1.0F / max(squared, splat(1e-20F));
  for (int c = 0; c < kChannels; ++c) {
    wanted[0][c] = mean[c] + low * scale * axis[c];
    wanted[1][c] = mean[c] + high * scale * axis[c];
  }
}

/// Fits a subset: the extent, then `rounds` of least squares.
template <class SubsetFit, int kChannels>
CAIRN_INLINE SubsetFit fit_subset(const Pixels& pixels, const I member[16], I odd_only, int rounds) {
  F wanted[2][4];
  principal_ends<kChannels>(pixels, member, 4, wanted);
  SubsetFit fit;
  fit.quantise(wanted, odd_only);
  fit.assign(pixels, member);
  for (int n = 0; n < rounds; ++n) fit.refine(pixels, member, odd_only);
  return fit;
}

using Mode0Fit = Fit<3, 4, PBits::each_end, 3>;
using Mode1Fit = Fit<3, 6, PBits::shared, 3>;
using Mode3Fit = Fit<2, 7, PBits::each_end, 3>;
using Mode2Fit = Fit<2, 5, PBits::none, 3>;
using Mode4Colour = Fit<2, 5, PBits::none, 3>;
using Mode4Scalar = Fit<3, 6, PBits::none, 1>;
using Mode5Colour = Fit<2, 7, PBits::none, 3>;
using Mode5Scalar = Fit<2, 8, PBits::none, 1>;
using Mode6Fit = Fit<4, 7, PBits::each_end, 4>;

}  // namespace cairn::CAIRN_ISA
