#include "builder/texture_encode/kernel_list.h"
#include "builder/texture_encode/simd.h"

namespace cairn::CAIRN_ISA {

namespace {

struct AlphaBlock {
  I high, low;     // the ends: high first, so eight values
  F position[16];  // 0 at high, 7 at low
  F error;
};

CAIRN_INLINE AlphaBlock nearest_positions(const F value[16], I high, I low) {
  AlphaBlock found{high, low, {}, {}};
  const F first = to_float(high), step = (to_float(low) - first) * (1 / 7.0F);
  const F scale = 7.0F / min(to_float(low) - first, splat(-1.0F));
  for (int i = 0; i < 16; ++i) {
    const F position = to_float(truncate(clamp((value[i] - first) * scale + 0.5F, 0, 7)));
    const F off = first + position * step - value[i];
    found.position[i] = position;
    found.error += off * off;
  }
  return found;
}

CAIRN_INLINE AlphaBlock refit(const F value[16], const AlphaBlock& from) {
  F n{}, nn{}, v{}, nv{};
  for (int i = 0; i < 16; ++i) {
    n += from.position[i];
    nn += from.position[i] * from.position[i];
    v += value[i];
    nv += from.position[i] * value[i];
  }
  const F spread = 16.0F * nn - n * n;
  const F slope = (16.0F * nv - n * v) / max(spread, splat(1.0F));
  const F first = (v - slope * n) * (1 / 16.0F);
  const I high = truncate(clamp(first + 0.5F, 0, 255)),
          low = truncate(clamp(first + 7.0F * slope + 0.5F, 0, 255));
  return nearest_positions(value, max(high, low), min(high, low));
}

CAIRN_INLINE void write(const AlphaBlock& block, std::byte* out, std::ptrdiff_t out_stride) {
  // Position 0 is index 0, position 7 index 1, the others one more than themselves.
  const I flat = block.high == block.low;
  I halves[2] = {};
  for (int i = 0; i < 16; ++i) {
    const I position = truncate(block.position[i]);
    const I index = select(position == 7, splat(1), position + ((position > 0) & 1)) & ~flat;
    halves[i / 8] |= index << (3 * (i % 8));
  }
  for (int lane = 0; lane < kLanes; ++lane) {
    std::byte* to = out + block_of_lane(lane) * out_stride;
    const auto low = static_cast<std::uint64_t>(halves[0][lane]),
               high = static_cast<std::uint64_t>(halves[1][lane]);
    const std::uint64_t bits = static_cast<std::uint64_t>(block.high[lane]) |
                               static_cast<std::uint64_t>(block.low[lane]) << 8 | low << 16 | high << 40;
    std::memcpy(to, &bits, 8);
  }
}

CAIRN_INLINE void encode_alpha(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                               std::ptrdiff_t out_stride, int rounds) {
  for (int first = 0; first < kKernelBlocks; first += kLanes) {
    I texel[16];
    load_texels(texels + 16 * first, stride, texel);
    F value[16];
    I high = splat(0), low = splat(255);
    for (int i = 0; i < 16; ++i) {
      value[i] = to_float(alpha(texel[i]));
      high = max(high, alpha(texel[i]));
      low = min(low, alpha(texel[i]));
    }
    AlphaBlock best = nearest_positions(value, high, low);
    for (int round = 0; round < rounds; ++round) {
      const AlphaBlock other = refit(value, best);
      const I better = other.error < best.error;
      best.high = select(better, other.high, best.high);
      best.low = select(better, other.low, best.low);
      best.error = min(other.error, best.error);
      for (int i = 0; i < 16; ++i) best.position[i] = select(better, other.position[i], best.position[i]);
    }
    write(best, out + first * out_stride, out_stride);
  }
}

}  // namespace

void encode_alpha_fast(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                       std::ptrdiff_t out_stride) {
  encode_alpha(texels, stride, out, out_stride, 0);
}

void encode_alpha_normal(const std::uint8_t* texels, std::ptrdiff_t stride, std::byte* out,
                         std::ptrdiff_t out_stride) {
  encode_alpha(texels, stride, out, out_stride, 2);
}

}  // namespace cairn::CAIRN_ISA
