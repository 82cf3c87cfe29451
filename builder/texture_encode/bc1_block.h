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

/// The line between two ends: `steps` steps from end 0 (step 0) to end 1. A deviation c lies c·step + first
/// along it.
struct Line {
  F step[3];
  F first;
  F squared;   ///< length, in colour
  F from_end;  ///< squared distance of end 0 from the mean
};

CAIRN_INLINE Line line_between(const Colours& colours, const F ends[2][3], int steps) {
  Line line;
  F offset[3];
  for (int c = 0; c < 3; ++c) {
    offset[c] = ends[0][c] - colours.mean[c];
    line.step[c] = ends[1][c] - ends[0][c];
  }
  line.from_end = offset[0] * offset[0] + offset[1] * offset[1] + offset[2] * offset[2];
  line.squared = line.step[0] * line.step[0] + line.step[1] * line.step[1] + line.step[2] * line.step[2];
  const F scale = static_cast<float>(steps) / max(line.squared, splat(1.0F));
  for (F& step : line.step) step *= scale;
  line.first = -(offset[0] * line.step[0] + offset[1] * line.step[1] + offset[2] * line.step[2]);
  return line;
}

/// Where texel i lies, and the nearest whole step to it.
struct Place {
  F along, nearest;
};

CAIRN_INLINE Place place_on(const Line& line, const Colours& colours, int i, int steps) {
  const F along = colours.channel[0][i] * line.step[0] + colours.channel[1][i] * line.step[1] +
                  (colours.channel[2][i] * line.step[2] + line.first);
  return {along, round(clamp(along, 0, static_cast<float>(steps)))};
}

/// How errors are summed: `quick` takes the projection's word for it, and rounds more coarsely by
/// cancellation: |c − o − n·s|² where the deviations c sum to zero and c·s is known.
enum class Errors { quick, exact };

CAIRN_INLINE F quick_term(const Place& place) {
  return place.nearest * (place.nearest - (place.along + place.along));
}

CAIRN_INLINE F exact_term(const Colours& colours, const Ends& ends, int i, F position) {
  F squares{};
  for (int c = 0; c < 3; ++c) {
    const F from = ends.value[0][c] - colours.mean[c];
    const F off =
        colours.channel[c][i] - (from + position * ((ends.value[1][c] - ends.value[0][c]) * (1 / 3.0F)));
    squares += off * off;
  }
  return squares;
}

CAIRN_INLINE F quick_error(const Colours& colours, const Line& line, F sum, int steps) {
  return colours.variance + 16.0F * line.from_end +
         sum * line.squared * (1 / static_cast<float>(steps * steps));
}

/// The error of giving every texel the nearest of four colours.
CAIRN_INLINE F least_error(const Colours& colours, const F ends[2][3]) {
  const Line line = line_between(colours, ends, 3);
  F sum{};
  for (int i = 0; i < 16; ++i) sum += quick_term(place_on(line, colours, i, 3));
  return quick_error(colours, line, sum, 3);
}

/// Gives every texel the nearest of the steps + 1 colours of the line between the ends.
template <Errors kErrors>
CAIRN_INLINE Candidate nearest_positions(const Colours& colours, const Ends& ends, int steps = 3) {
  const Line line = line_between(colours, ends.value, steps);
  Candidate found{ends, {}, {}};
  F sum{};
  for (int i = 0; i < 16; ++i) {
    const Place place = place_on(line, colours, i, steps);
    found.position[i] = place.nearest * (3.0F / static_cast<float>(steps));
    if constexpr (kErrors == Errors::quick) sum += quick_term(place);
    if constexpr (kErrors == Errors::exact) sum += exact_term(colours, ends, i, found.position[i]);
  }
  found.error = kErrors == Errors::quick ? quick_error(colours, line, sum, steps) : sum;
  return found;
}

/// What a block's positions mean for the ends: Σ(1−t)², Σt², Σt(1−t) with t = position/3 in 0..1, and Σt·c in
/// each channel, where c are the deviations from the mean.
struct Weights {
  F aa, bb, ab;
  F products[3];
};

/// Of the four ways to round a pair of ends, the one with the least error aa·a² + bb·b² + 2ab·a·b + 2(a −
/// b)·Σt·c, where a, b are the ends' deviations from the mean. Returns that error, which lacks Σc².
CAIRN_INLINE F round_pair(const Weights& weights, F mean, F a, F b, int channel, Ends& ends) {
  const float steps = static_cast<float>((1 << kChannelBits[channel]) - 1);
  const I low_a = truncate(clamp((mean + a) * (steps / 255), 0, steps - 1));
  const I low_b = truncate(clamp((mean + b) * (steps / 255), 0, steps - 1));
  const F twice_product = 2.0F * weights.products[channel];
  F least = splat(1e30F);
  for (int up_a = 0; up_a < 2; ++up_a) {
    const I stored_a = low_a + up_a;
    const F value_a = to_float(widen(stored_a, channel));
    const F off_a = value_a - mean;
    const F part = off_a * (weights.aa * off_a + twice_product);
    const F slope = 2.0F * weights.ab * off_a - twice_product;
    for (int up_b = 0; up_b < 2; ++up_b) {
      const I stored_b = low_b + up_b;
      const F value_b = to_float(widen(stored_b, channel));
      const F off_b = value_b - mean;
      const F error = part + off_b * (weights.bb * off_b + slope);
      const I better = error < least;
      least = min(error, least);
      ends.stored[0][channel] = select(better, stored_a, ends.stored[0][channel]);
      ends.stored[1][channel] = select(better, stored_b, ends.stored[1][channel]);
      ends.value[0][channel] = select(better, value_a, ends.value[0][channel]);
      ends.value[1][channel] = select(better, value_b, ends.value[1][channel]);
    }
  }
  return least;
}

/// The best ends for given weights: least squares, then the best of the four roundings of each channel.
/// Returns the error less Σc².
CAIRN_INLINE F fit_ends(const Colours& colours, const Weights& weights, Ends& ends) {
  const F mean = (weights.bb + weights.ab) * (1 / 16.0F);  // of t
  const F scale = 1.0F / max(weights.bb - 16.0F * mean * mean, splat(1e-3F));
  F error{};
  for (int c = 0; c < 3; ++c) {
    const F slope = weights.products[c] * scale;
    error += round_pair(weights, colours.mean[c], -slope * mean, slope - slope * mean, c, ends);
  }
  return error;
}

/// Sums of positions, from which their weights are.
struct PositionSums {
  F sum, squares;
  F products[3];  ///< with the deviations
};

CAIRN_INLINE void add_position(const Colours& colours, int i, F position, PositionSums& sums) {
  sums.sum += position;
  sums.squares += position * position;
  for (int c = 0; c < 3; ++c) sums.products[c] += position * colours.channel[c][i];
}

CAIRN_INLINE Weights weights_of(const PositionSums& sums) {
  Weights weights;
  for (int c = 0; c < 3; ++c) weights.products[c] = sums.products[c] * (1 / 3.0F);
  weights.bb = sums.squares * (1 / 9.0F);
  weights.ab = sums.sum * (1 / 3.0F) - weights.bb;
  weights.aa = 16.0F - 2.0F * weights.ab - weights.bb;
  return weights;
}

CAIRN_INLINE Weights weights_of(const Colours& colours, const F position[16]) {
  PositionSums sums{};
  for (int i = 0; i < 16; ++i) add_position(colours, i, position[i], sums);
  return weights_of(sums);
}

CAIRN_INLINE void keep_better(const Ends& other, I better, Ends& best) {
  for (int e = 0; e < 2; ++e) {
    for (int c = 0; c < 3; ++c) {
      best.stored[e][c] = select(better, other.stored[e][c], best.stored[e][c]);
      best.value[e][c] = select(better, other.value[e][c], best.value[e][c]);
    }
  }
}

CAIRN_INLINE void keep_better(const Candidate& other, Candidate& best) {
  const I better = other.error < best.error;
  keep_better(other.ends, better, best.ends);
  best.error = min(other.error, best.error);
  for (int i = 0; i < 16; ++i) best.position[i] = select(better, other.position[i], best.position[i]);
}

/// Ends from positions, positions from ends, and keep what is better.
template <Errors kErrors>
CAIRN_INLINE void refine(const Colours& colours, Candidate& best, int steps = 3) {
  Ends ends{};
  fit_ends(colours, weights_of(colours, best.position), ends);
  keep_better(nearest_positions<kErrors>(colours, ends, steps), best);
}

inline constexpr OneColourTable kOneColour5 = one_colour_table(5, third_of_the_way);
inline constexpr OneColourTable kOneColour6 = one_colour_table(6, third_of_the_way);

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

/// The 64 bits of a block.
struct Code {
  I ends, indices;
};

CAIRN_INLINE I pack_565(const I stored[3]) {
  return stored[0] << 11 | stored[1] << 5 | stored[2];
}

/// The mode of four colours: ends descend. Positions 0 1 2 3 are indices 0 2 3 1.
CAIRN_INLINE Code four_colour_code(const Candidate& best) {
  I positions{};
  for (int i = 0; i < 16; ++i) positions |= truncate(best.position[i]) << (2 * i);
  I indices = ((positions ^ positions << 1) & ~0x55555555) | (positions >> 1 & 0x55555555);
  const I a = pack_565(best.ends.stored[0]), b = pack_565(best.ends.stored[1]);
  indices = (indices ^ ((a < b) & 0x55555555)) & ~(a == b);
  return {max(a, b) | min(a, b) << 16, indices};
}

/// The mode of three colours: ends ascend. Positions 0 1.5 3 are indices 0 2 1.
CAIRN_INLINE Code three_colour_code(const Candidate& best) {
  I indices{};
  for (int i = 0; i < 16; ++i) {
    const I position = truncate(best.position[i]);
    indices |= (((position == 1) & 2) | ((position == 3) & 1)) << (2 * i);
  }
  const I a = pack_565(best.ends.stored[0]), b = pack_565(best.ends.stored[1]);
  const I ends_only = ~(indices >> 1) & 0x55555555;
  return {min(a, b) | max(a, b) << 16, indices ^ ((a > b) & ends_only)};
}

CAIRN_INLINE Code select(I mask, const Code& a, const Code& b) {
  return {select(mask, a.ends, b.ends), select(mask, a.indices, b.indices)};
}

CAIRN_INLINE void write_blocks(const Code& code, std::byte* out, std::ptrdiff_t out_stride) {
  for (int lane = 0; lane < kLanes; ++lane) {
    const std::int32_t halves[2] = {code.ends[lane], code.indices[lane]};
    std::memcpy(out + block_of_lane(lane) * out_stride, halves, 8);
  }
}

}  // namespace cairn::CAIRN_ISA
