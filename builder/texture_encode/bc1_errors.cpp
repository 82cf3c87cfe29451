#include "builder/texture_encode/kernel_list.h"
#include "builder/texture_encode/simd.h"

namespace cairn::CAIRN_ISA {

namespace {

CAIRN_INLINE I five_bits(I packed, int shift) {
  const I stored = packed >> shift & 31;
  return stored << 3 | stored >> 2;
}
CAIRN_INLINE I six_bits(I packed, int shift) {
  const I stored = packed >> shift & 63;
  return stored << 2 | stored >> 4;
}

/// REQUIRES: 0 <= value < 3·256.
CAIRN_INLINE I third(I value) {
  return value * 43691 >> 17;
}

/// The four colours' values in one channel, as decode_bc1_block() has them.
struct Palette {
  I value[4];
};

CAIRN_INLINE Palette palette_of(I a, I b, I four_colours) {
  return {a, b, select(four_colours, third(2 * a + b + 1), (a + b) >> 1),
          third(a + 2 * b + 1) & four_colours};
}

}  // namespace

void bc1_errors(const std::uint8_t* texels, std::ptrdiff_t stride, const std::byte* blocks,
                std::uint32_t* errors) {
  for (int first = 0; first < kKernelBlocks; first += kLanes) {
    std::int32_t lanes[2][kLanes];
    for (int lane = 0; lane < kLanes; ++lane) {
      std::memcpy(&lanes[0][lane], blocks + 8 * (first + block_of_lane(lane)), 4);
      std::memcpy(&lanes[1][lane], blocks + 8 * (first + block_of_lane(lane)) + 4, 4);
    }
    I ends, indices;
    std::memcpy(&ends, lanes[0], sizeof ends);
    std::memcpy(&indices, lanes[1], sizeof indices);
    const I four_colours = (ends & 0xFFFF) > (ends >> 16 & 0xFFFF);
    const Palette red_of = palette_of(five_bits(ends, 11), five_bits(ends, 27), four_colours);
    const Palette green_of = palette_of(six_bits(ends, 5), six_bits(ends, 21), four_colours);
    const Palette blue_of = palette_of(five_bits(ends, 0), five_bits(ends, 16), four_colours);

    I texel[16];
    load_texels(texels + 16 * first, stride, texel);
    I sum{};
    for (int i = 0; i < 16; ++i) {
      const I odd = (indices & 1) != 0, high = (indices & 2) != 0;
      const auto off = [&](const Palette& p, I value) {
        return value - select(high, select(odd, p.value[3], p.value[2]), select(odd, p.value[1], p.value[0]));
      };
      const I r = off(red_of, red(texel[i])), g = off(green_of, green(texel[i])),
              b = off(blue_of, blue(texel[i]));
      sum += r * r + g * g + b * b;
      indices >>= 2;
    }
    for (int lane = 0; lane < kLanes; ++lane)
      errors[first + block_of_lane(lane)] = static_cast<std::uint32_t>(sum[lane]);
  }
}

}  // namespace cairn::CAIRN_ISA
