#pragma once

// The steps that the BC1 kernels are made of. In every lane, one block.
//
// A block's colours are drawn from a line of four: position 0 is end 0, position 3 end 1. The least-squares
// ends for given positions are van Waveren, "Real-Time DXT Compression" (2006), and Giesen, stb_dxt; the
// difference here is that all sums are of deviations from the block's mean, so that the regression falls
// apart into one slope.

#include "builder/texture_encode/one_colour.h"
#include "builder/texture_encode/simd.h"

namespace cairn::CAIRN_ISA {

/// Deviations of 16 colours from their mean.
struct Colours {
  F channel[3][16];
  F mean[3];
  F variance;  ///< sum of the squares of all deviations
};

struct Ends {
  I stored[2][3];  ///< 5, 6, 5 bits
  F value[2][3];   ///< 0..255
};

/// A way to encode the block, and what it costs.
struct Candidate {
  Ends ends;
  F position[16];
  F error;  ///< sum of squares over all texels and channels
};

inline constexpr int kChannelBits[3] = {5, 6, 5};

CAIRN_INLINE I widen(I stored, int channel) {
  return channel == 1 ? stored << 2 | stored >> 4 : stored << 3 | stored >> 2;
}

CAIRN_INLINE Colours load_colours(const std::uint8_t* texels, std::ptrdiff_t stride) {
  I packed[16];
  load_texels(texels, stride, packed);
  Colours colours;
  for (int c = 0; c < 3; ++c) {
    I sum{};
    for (int i = 0; i < 16; ++i) {
      const I value = packed[i] >> (8 * c) & 255;
      sum += value;
      colours.channel[c][i] = to_float(value);
    }
    colours.mean[c] = to_float(sum) * (1 / 16.0F);
    for (int i = 0; i < 16; ++i) colours.channel[c][i] -= colours.mean[c];
  }
  return colours;
}

struct Axis {
  F r, g, b;
};

/// The principal axis by power iteration, not normalised: its largest component is 1, or all are 0. Fills
/// variance.
CAIRN_INLINE Axis principal_axis(Colours& colours, int iterations) {
  F rr{}, rg{}, rb{}, gg{}, gb{}, bb{};
  for (int i = 0; i < 16; ++i) {
    const F r = colours.channel[0][i], g = colours.channel[1][i], b = colours.channel[2][i];
    rr += r * r, rg += r * g, rb += r * b, gg += g * g, gb += g * b, bb += b * b;
  }
  colours.variance = rr + gg + bb;
  // The row of the channel that varies most is never orthogonal to the axis.
  const I red_most = rr >= gg, blue_most = bb > max(rr, gg);
  Axis axis{select(red_most, rr, rg), select(red_most, rg, gg), select(red_most, rb, gb)};
  axis = {select(blue_most, rb, axis.r), select(blue_most, gb, axis.g), select(blue_most, bb, axis.b)};
  for (int i = 0; i < iterations; ++i) {
    const Axis turned{rr * axis.r + rg * axis.g + rb * axis.b, rg * axis.r + gg * axis.g + gb * axis.b,
                      rb * axis.r + gb * axis.g + bb * axis.b};
    const F largest = max(max(max(turned.r, -turned.r), max(turned.g, -turned.g)), max(turned.b, -turned.b));
    const F scale = 1.0F / max(largest, splat(1e-20F));
    axis = {turned.r * scale, turned.g * scale, turned.b * scale};
  }
  return axis;
}

/// The 565 colour nearest to each end.
CAIRN_INLINE Ends nearest_ends(const F wanted[2][3]) {
  Ends ends;
  for (int e = 0; e < 2; ++e) {
    for (int c = 0; c < 3; ++c) {
      const float steps = static_cast<float>((1 << kChannelBits[c]) - 1);
      ends.stored[e][c] = truncate(clamp(wanted[e][c], 0, 255) * (steps / 255) + 0.5F);
      ends.value[e][c] = to_float(widen(ends.stored[e][c], c));
    }
  }
  return ends;
}

/// The extent of the colours along the axis, drawn in by 1/16 of itself at both ends: what lies outside is
/// rare.
CAIRN_INLINE Ends extent_ends(const Colours& colours, const Axis& axis) {
  F low = splat(1e9F), high = splat(-1e9F);
  for (int i = 0; i < 16; ++i) {
    const F along =
        axis.r * colours.channel[0][i] + axis.g * colours.channel[1][i] + axis.b * colours.channel[2][i];
    low = min(low, along);
    high = max(high, along);
  }
  const F inset = (high - low) * (1 / 16.0F);
  const F scale = 1.0F / max(axis.r * axis.r + axis.g * axis.g + axis.b * axis.b, splat(1e-20F));
  low = (low + inset) * scale;
  high = (high - inset) * scale;
  const F components[3] = {axis.r, axis.g, axis.b};
  F wanted[2][3];
  for (int c = 0; c < 3; ++c) {
    wanted[0][c] = colours.mean[c] + low * components[c];
    wanted[1][c] = colours.mean[c] + high * components[c];
  }
  return nearest_ends(wanted);
}

/// Gives every texel the nearest colour of the line between the ends.
CAIRN_INLINE Candidate nearest_positions(const Colours& colours, const Ends& ends) {
  F offset[3], step[3];
  for (int c = 0; c < 3; ++c) {
    offset[c] = ends.value[0][c] - colours.mean[c];
    step[c] = ends.value[1][c] - ends.value[0][c];
  }
  const F squared = step[0] * step[0] + step[1] * step[1] + step[2] * step[2];
  const F scale = 3.0F / max(squared, splat(1.0F));
  for (int c = 0; c < 3; ++c) step[c] *= scale;
  const F first = offset[0] * step[0] + offset[1] * step[1] + offset[2] * step[2];

  Candidate found{ends, {}, {}};
  F sum{};
  for (int i = 0; i < 16; ++i) {
    const F along = colours.channel[0][i] * step[0] + colours.channel[1][i] * step[1] +
                    colours.channel[2][i] * step[2] - first;
    const F position = to_float(truncate(clamp(along + 0.5F, 0, 3)));
    found.position[i] = position;
    sum += position * (position - 2.0F * along);
  }
  // |c − o − p·s|² summed, where the deviations c sum to zero and c·s is known from the projection.
  const F from_end = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
  found.error = colours.variance + 16.0F * from_end + sum * squared * (1 / 9.0F);
  return found;
}

/// The four ways to round a pair of ends, tried against the exact quadratic of one channel's error:
/// aa·a² + bb·b² + 2ab·a·b − 2(a·ca + b·cb).
struct Quadratic {
  F aa, bb, ab, ca, cb;
};

CAIRN_INLINE void round_pair(const Quadratic& q, F a, F b, int channel, Ends& ends) {
  const float steps = static_cast<float>((1 << kChannelBits[channel]) - 1);
  const I low_a = truncate(clamp(a * (steps / 255), 0, steps - 1));
  const I low_b = truncate(clamp(b * (steps / 255), 0, steps - 1));
  F least = splat(1e30F);
  for (int up_a = 0; up_a < 2; ++up_a) {
    const I stored_a = low_a + up_a;
    const F value_a = to_float(widen(stored_a, channel));
    const F part = value_a * (q.aa * value_a - 2.0F * q.ca);
    for (int up_b = 0; up_b < 2; ++up_b) {
      const I stored_b = low_b + up_b;
      const F value_b = to_float(widen(stored_b, channel));
      const F error = part + value_b * (q.bb * value_b - 2.0F * (q.cb - q.ab * value_a));
      const I better = error < least;
      least = min(error, least);
      ends.stored[0][channel] = select(better, stored_a, ends.stored[0][channel]);
      ends.stored[1][channel] = select(better, stored_b, ends.stored[1][channel]);
      ends.value[0][channel] = select(better, value_a, ends.value[0][channel]);
      ends.value[1][channel] = select(better, value_b, ends.value[1][channel]);
    }
  }
}

/// The best ends for given positions: least squares, then the best of the four roundings of each channel.
CAIRN_INLINE Ends fit_ends(const Colours& colours, const F position[16]) {
  F sum{}, squares{}, products[3] = {};
  for (int i = 0; i < 16; ++i) {
    sum += position[i];
    squares += position[i] * position[i];
    for (int c = 0; c < 3; ++c) products[c] += position[i] * colours.channel[c][i];
  }
  const F mean = sum * (1 / 16.0F);
  const F scale = 1.0F / max(squares - sum * mean, splat(1e-3F));
  Quadratic q;
  q.bb = squares * (1 / 9.0F);
  q.ab = sum * (1 / 3.0F) - q.bb;
  q.aa = 16.0F - 2.0F * q.ab - q.bb;
  Ends ends{};
  for (int c = 0; c < 3; ++c) {
    const F slope = products[c] * scale;
    q.cb = (products[c] + colours.mean[c] * sum) * (1 / 3.0F);
    q.ca = colours.mean[c] * 16.0F - q.cb;
    round_pair(q, colours.mean[c] - slope * mean, colours.mean[c] + slope * (3.0F - mean), c, ends);
  }
  return ends;
}

CAIRN_INLINE void keep_better(const Candidate& other, Candidate& best) {
  const I better = other.error < best.error;
  best.error = min(other.error, best.error);
  for (int i = 0; i < 16; ++i) best.position[i] = select(better, other.position[i], best.position[i]);
  for (int e = 0; e < 2; ++e) {
    for (int c = 0; c < 3; ++c) {
      best.ends.stored[e][c] = select(better, other.ends.stored[e][c], best.ends.stored[e][c]);
      best.ends.value[e][c] = select(better, other.ends.value[e][c], best.ends.value[e][c]);
    }
  }
}

/// Ends from positions, positions from ends, and keep what is better.
CAIRN_INLINE void refine(const Colours& colours, Candidate& best) {
  keep_better(nearest_positions(colours, fit_ends(colours, best.position)), best);
}

inline constexpr OneColourTable kOneColour5 = one_colour_table(5);
inline constexpr OneColourTable kOneColour6 = one_colour_table(6);

/// The whole block in the colour nearest to its mean.
CAIRN_INLINE Candidate one_colour(const Colours& colours) {
  Candidate found{};
  F off{};
  for (int c = 0; c < 3; ++c) {
    const I ends = lookup(c == 1 ? kOneColour6.ends : kOneColour5.ends, truncate(colours.mean[c] + 0.5F));
    found.ends.stored[0][c] = ends & 255;
    found.ends.stored[1][c] = ends >> 8;
    for (int e = 0; e < 2; ++e) found.ends.value[e][c] = to_float(widen(found.ends.stored[e][c], c));
    const F thirds = 2.0F * found.ends.value[0][c] + found.ends.value[1][c] + 1.0F;
    // As decoders round it: the margin is wider than a float's error and narrower than a third.
    const F value = to_float(truncate(thirds * (1 / 3.0F) + 0.01F)) - colours.mean[c];
    off += value * value;
  }
  for (F& position : found.position) position = splat(1.0F);
  // Where all texels are equal nothing is better; the errors of other candidates are not rounded as decoders
  // round.
  found.error = select(colours.variance == 0, F{} - 1.0F, colours.variance + 16.0F * off);
  return found;
}

/// Writes the blocks in the mode of four colours.
CAIRN_INLINE void write_four_colours(const Candidate& best, std::byte* out, std::ptrdiff_t out_stride) {
  I indices{};
  for (int i = 0; i < 16; ++i) {
    const I position = truncate(best.position[i]);
    // Position 0 1 2 3 is index 0 2 3 1.
    const I index = position + (((position == 1) | (position == 2)) & 1) - ((position == 3) & 2);
    indices |= index << (2 * i);
  }
  I packed[2];
  for (int e = 0; e < 2; ++e) {
    packed[e] = best.ends.stored[e][0] << 11 | best.ends.stored[e][1] << 5 | best.ends.stored[e][2];
  }
  const I ascending = packed[0] < packed[1];
  const I larger = max(packed[0], packed[1]), smaller = min(packed[0], packed[1]);
  indices = (indices ^ (ascending & 0x55555555)) & ~(packed[0] == packed[1]);
  const I ends = larger | smaller << 16;
  for (int lane = 0; lane < kLanes; ++lane) {
    std::byte* block = out + block_of_lane(lane) * out_stride;
    const std::int32_t halves[2] = {ends[lane], indices[lane]};
    std::memcpy(block, halves, 8);
  }
}

}  // namespace cairn::CAIRN_ISA
