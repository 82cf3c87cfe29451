#include "format/block_texture.h"

#include <algorithm>
#include <cassert>
#include <string>

#include "format/bytes.h"

namespace cairn {

namespace {

using Texel = std::array<std::uint8_t, 4>;

Texel unpack_565(unsigned packed) {
  const unsigned r = packed >> 11, g = packed >> 5 & 63, b = packed & 31;
  return {static_cast<std::uint8_t>(r << 3 | r >> 2), static_cast<std::uint8_t>(g << 2 | g >> 4),
          static_cast<std::uint8_t>(b << 3 | b >> 2), 255};
}

// (a·p + b·q) / (p+q) of each channel, to the nearest.
Texel blend(const Texel& a, int p, const Texel& b, int q) {
  Texel mixed{};
  for (std::size_t c = 0; c < 4; ++c) {
    mixed[c] = static_cast<std::uint8_t>((a[c] * p + b[c] * q + (p + q) / 2) / (p + q));
  }
  return mixed;
}

enum class Holes { never, where_ends_ascend };

void decode_colours(std::span<const std::byte> block, Holes holes, BlockTexels& texels) {
  ByteReader reader(block);
  const unsigned end0 = reader.read<std::uint16_t>();
  const unsigned end1 = reader.read<std::uint16_t>();
  std::uint32_t indices = reader.read<std::uint32_t>();

  const Texel a = unpack_565(end0), b = unpack_565(end1);
  std::array<Texel, 4> palette = {a, b, blend(a, 2, b, 1), blend(a, 1, b, 2)};
  if (holes == Holes::where_ends_ascend && end0 <= end1) {
    palette[2] = {static_cast<std::uint8_t>((a[0] + b[0]) / 2), static_cast<std::uint8_t>((a[1] + b[1]) / 2),
                  static_cast<std::uint8_t>((a[2] + b[2]) / 2), 255};
    palette[3] = {0, 0, 0, 0};
  }
  for (std::size_t i = 0; i < 16; ++i, indices >>= 2) {
    std::copy_n(palette[indices & 3].begin(), 4, texels.begin() + static_cast<std::ptrdiff_t>(4 * i));
  }
}

void decode_alphas(std::span<const std::byte> block, BlockTexels& texels) {
  ByteReader reader(block);
  const auto bits = reader.read<std::uint64_t>();
  const int a = static_cast<int>(bits & 255), b = static_cast<int>(bits >> 8 & 255);
  std::array<int, 8> palette = {a, b, 0, 0, 0, 0, 0, 255};
  const int steps = a > b ? 7 : 5;
  for (int i = 1; i < steps; ++i) {
    palette[static_cast<std::size_t>(i + 1)] = (a * (steps - i) + b * i + steps / 2) / steps;
  }
  for (std::size_t i = 0; i < 16; ++i) {
    texels[4 * i + 3] = static_cast<std::uint8_t>(palette[bits >> (16 + 3 * i) & 7]);
  }
}

BlockTexels decode_block(TextureFormat format, const std::byte* block) {
  switch (format) {
    case TextureFormat::bc1:
      return decode_bc1_block(std::span<const std::byte, 8>(block, 8));
    case TextureFormat::bc3:
      return decode_bc3_block(std::span<const std::byte, 16>(block, 16));
    case TextureFormat::bc7:
      return decode_bc7_block(std::span<const std::byte, 16>(block, 16));
  }
  assert(false && "no such TextureFormat");
  return {};
}

}  // namespace

BlockTexels decode_bc1_block(std::span<const std::byte, 8> block) {
  BlockTexels texels;
  decode_colours(block, Holes::where_ends_ascend, texels);
  return texels;
}

BlockTexels decode_bc3_block(std::span<const std::byte, 16> block) {
  BlockTexels texels;
  decode_colours(block.last<8>(), Holes::never, texels);
  decode_alphas(block.first<8>(), texels);
  return texels;
}

Status decode_texture(TextureFormat format, std::span<const std::byte> blocks, int width, int height,
                      std::span<std::uint8_t> rgba) {
  assert(width >= 1 && height >= 1);
  const std::size_t w = static_cast<std::size_t>(width), h = static_cast<std::size_t>(height);
  assert(rgba.size() == w * h * 4);
  const std::uint64_t expected = texture_bytes(format, width, height);
  if (blocks.size() != expected) {
    return bad_data("texture: expected " + std::to_string(expected) + " bytes of blocks, found " +
                    std::to_string(blocks.size()));
  }
  const std::byte* block = blocks.data();
  for (std::size_t top = 0; top < h; top += 4) {
    for (std::size_t left = 0; left < w; left += 4, block += block_bytes(format)) {
      const BlockTexels texels = decode_block(format, block);
      for (std::size_t y = top; y < std::min(h, top + 4); ++y) {
        std::copy_n(texels.begin() + static_cast<std::ptrdiff_t>(16 * (y - top)),
                    4 * std::min<std::size_t>(4, w - left),
                    rgba.begin() + static_cast<std::ptrdiff_t>(4 * (y * w + left)));
      }
    }
  }
  return {};
}

}  // namespace cairn
