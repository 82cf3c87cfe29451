#include "format/block_texture.h"

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

namespace cairn {

namespace {

using Texel = std::array<int, 4>;

Texel texel(const BlockTexels& texels, std::size_t i) {
  return {texels[4 * i], texels[4 * i + 1], texels[4 * i + 2], texels[4 * i + 3]};
}

template <std::size_t N>
std::array<std::byte, N> random_block(std::mt19937& random) {
  std::array<std::byte, N> block;
  for (std::byte& byte : block) byte = static_cast<std::byte>(random() & 255);
  return block;
}

std::array<std::byte, 8> colour_block(unsigned end0, unsigned end1, std::uint32_t indices) {
  const std::uint32_t halves[2] = {end0 | end1 << 16, indices};
  std::array<std::byte, 8> block;
  std::memcpy(block.data(), halves, 8);
  return block;
}

// Writes `count` bits of `value` at bit `at` of a BC7 block, the lowest first, and moves on.
void put(std::array<std::byte, 16>& block, unsigned& at, unsigned value, unsigned count) {
  for (unsigned bit = 0; bit < count; ++bit, ++at) {
    if (value >> bit & 1) block[at / 8] |= static_cast<std::byte>(1U << at % 8);
  }
}

}  // namespace

TEST_CASE("a BC1 block has its ends and their thirds where the ends descend") {
  const BlockTexels texels = decode_bc1_block(colour_block(0xF800, 0x001F, 0b11'10'01'00));
  CHECK(texel(texels, 0) == Texel{255, 0, 0, 255});
  CHECK(texel(texels, 1) == Texel{0, 0, 255, 255});
  CHECK(texel(texels, 2) == Texel{170, 0, 85, 255});
  CHECK(texel(texels, 3) == Texel{85, 0, 170, 255});
  CHECK(texel(texels, 15) == Texel{255, 0, 0, 255});
}

TEST_CASE("a BC1 block has the middle of its ends, and holes, where the ends do not descend") {
  const BlockTexels texels = decode_bc1_block(colour_block(0x001F, 0xF800, 0b11'10'01'00));
  CHECK(texel(texels, 0) == Texel{0, 0, 255, 255});
  CHECK(texel(texels, 1) == Texel{255, 0, 0, 255});
  CHECK(texel(texels, 2) == Texel{127, 0, 127, 255});
  CHECK(texel(texels, 3) == Texel{0, 0, 0, 0});
  CHECK(texel(decode_bc1_block(colour_block(0x1234, 0x1234, 3)), 0) == Texel{0, 0, 0, 0});
}

TEST_CASE("colours between the ends of a BC1 block are rounded to the nearest") {
  std::mt19937 random(1);
  for (int n = 0; n < 2000; ++n) {
    const unsigned end0 = random() & 0xFFFF, end1 = random() & 0xFFFF;
    if (end0 <= end1) continue;
    const BlockTexels texels = decode_bc1_block(colour_block(end0, end1, 0b11'10'01'00));
    for (std::size_t c = 0; c < 3; ++c) {
      const double a = texels[c], b = texels[4 + c];
      REQUIRE(texels[8 + c] == std::lround((2 * a + b) / 3));
      REQUIRE(texels[12 + c] == std::lround((a + 2 * b) / 3));
    }
  }
}

TEST_CASE("a BC3 block has four colours whichever way its ends lie, and no hole") {
  std::array<std::byte, 16> block{};
  block[0] = std::byte{255};
  const auto colours = colour_block(0x001F, 0xF800, 0b11'10'01'00);
  std::copy(colours.begin(), colours.end(), block.begin() + 8);
  const BlockTexels texels = decode_bc3_block(block);
  CHECK(texel(texels, 2) == Texel{85, 0, 170, 255});
  CHECK(texel(texels, 3) == Texel{170, 0, 85, 255});
}

TEST_CASE("a BC3 block's alphas lie on sevenths, or on fifths with 0 and 255 apart") {
  for (const auto& [first, second] : {std::pair{200, 60}, std::pair{60, 200}, std::pair{77, 77}}) {
    std::array<std::byte, 16> block{};
    block[0] = static_cast<std::byte>(first);
    block[1] = static_cast<std::byte>(second);
    const std::uint64_t indices = 07654321'0;
    std::memcpy(&block[2], &indices, 6);
    const BlockTexels texels = decode_bc3_block(block);
    const int steps = first > second ? 7 : 5;
    CHECK(texels[3] == first);
    CHECK(texels[7] == second);
    for (int i = 1; i < steps; ++i) {
      const double exact = first + (second - first) * static_cast<double>(i) / steps;
      CHECK(texels[static_cast<std::size_t>(4 * (i + 1) + 3)] == std::lround(exact));
    }
    if (steps == 5) {
      CHECK(texels[4 * 6 + 3] == 0);
      CHECK(texels[4 * 7 + 3] == 255);
    }
  }
}

TEST_CASE("a BC7 block of the reserved mode is transparent black") {
  std::mt19937 random(2);
  auto block = random_block<16>(random);
  block[0] = std::byte{0};
  CHECK(decode_bc7_block(block) == BlockTexels{});
}

TEST_CASE("a BC7 block of mode 6 blends RGBA in sixteenths, the first index one bit short") {
  std::array<std::byte, 16> block{};
  unsigned at = 0;
  put(block, at, 1U << 6, 7);
  for (int channel = 0; channel < 4; ++channel) {
    put(block, at, 0, 7);
    put(block, at, 127, 7);
  }
  put(block, at, 0b10, 2);  // the second end is odd: 255
  put(block, at, 7, 3);
  for (unsigned index = 1; index < 16; ++index) put(block, at, index, 4);
  REQUIRE(at == 128);
  const BlockTexels texels = decode_bc7_block(block);
  CHECK(texel(texels, 0) == Texel{120, 120, 120, 120});  // (255·30 + 32) / 64
  CHECK(texel(texels, 1) == Texel{16, 16, 16, 16});
  CHECK(texel(texels, 15) == Texel{255, 255, 255, 255});
}

TEST_CASE("a BC7 block of mode 5 can swap alpha with a colour") {
  std::array<std::byte, 16> block{};
  unsigned at = 0;
  put(block, at, 1U << 5, 6);
  put(block, at, 2, 2);                                // alpha and green
  for (int i = 0; i < 2; ++i) put(block, at, 10, 7);   // red 20
  for (int i = 0; i < 2; ++i) put(block, at, 127, 7);  // "green" 255, which becomes alpha
  for (int i = 0; i < 2; ++i) put(block, at, 64, 7);   // blue 129
  for (int i = 0; i < 2; ++i) put(block, at, 40 + 60U * static_cast<unsigned>(i), 8);
  put(block, at, 0, 31);
  put(block, at, 1, 1);
  put(block, at, 0xFFFFFFFF >> 2, 30);
  REQUIRE(at == 128);
  const BlockTexels texels = decode_bc7_block(block);
  CHECK(texel(texels, 0) == Texel{20, 60, 129, 255});  // the anchor's 1: (40·43 + 100·21 + 32) / 64
  CHECK(texel(texels, 15) == Texel{20, 100, 129, 255});
}

TEST_CASE("every bit pattern decodes, and BC7's modes without alpha are opaque") {
  std::mt19937 random(3);
  for (int n = 0; n < 20000; ++n) {
    auto block = random_block<16>(random);
    (void)decode_bc1_block(std::span(block).first<8>());
    (void)decode_bc3_block(block);
    const unsigned mode = static_cast<unsigned>(n) % 8;
    block[0] = static_cast<std::byte>((static_cast<unsigned>(block[0]) | 1U) << mode);
    const BlockTexels texels = decode_bc7_block(block);
    for (std::size_t i = 0; i < 16 && mode < 4; ++i) REQUIRE(texels[4 * i + 3] == 255);
  }
}

TEST_CASE("a texture of any size decodes, block by block, and one of the wrong length is refused") {
  std::mt19937 random(4);
  for (const auto& [width, height] : {std::pair{1, 1}, std::pair{4, 4}, std::pair{5, 3}, std::pair{17, 9}}) {
    for (const TextureFormat format : {TextureFormat::bc1, TextureFormat::bc3, TextureFormat::bc7}) {
      std::vector<std::byte> blocks(texture_bytes(format, width, height));
      for (std::byte& byte : blocks) byte = static_cast<std::byte>(random() & 255);
      std::vector<std::uint8_t> rgba(static_cast<std::size_t>(width * height * 4), 77);
      REQUIRE(decode_texture(format, blocks, width, height, rgba).ok());

      const int x = width - 1, y = height - 1, number = y / 4 * ((width + 3) / 4) + x / 4;
      const std::byte* block = blocks.data() + static_cast<std::size_t>(number) * block_bytes(format);
      const BlockTexels last =
          format == TextureFormat::bc1   ? decode_bc1_block(std::span<const std::byte, 8>(block, 8))
          : format == TextureFormat::bc3 ? decode_bc3_block(std::span<const std::byte, 16>(block, 16))
                                         : decode_bc7_block(std::span<const std::byte, 16>(block, 16));
      CHECK(std::memcmp(&last[static_cast<std::size_t>(4 * (y % 4 * 4 + x % 4))], &rgba[rgba.size() - 4],
                        4) == 0);

      blocks.pop_back();
      CHECK(decode_texture(format, blocks, width, height, rgba).error().code == ErrorCode::bad_data);
      blocks.resize(blocks.size() + 2);
      CHECK_FALSE(decode_texture(format, blocks, width, height, rgba).ok());
    }
  }
}

}  // namespace cairn
