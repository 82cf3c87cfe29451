#include "cairn/texture_tile.h"

#include <random>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

TextureTile some_tile(TextureFormat format, int size) {
  std::mt19937 random(5);
  TextureTile tile{format, size, std::vector<std::byte>(texture_chain_bytes(format, size))};
  for (std::byte& b : tile.texels) b = static_cast<std::byte>(random() % 5);
  return tile;
}

}  // namespace

TEST_CASE("a mip chain has the bytes that a DDS file has") {
  CHECK(texture_image_bytes(TextureFormat::bc1, 512) == 512 * 512 / 2);
  CHECK(texture_image_bytes(TextureFormat::bc7, 512) == 512 * 512);
  CHECK(texture_image_bytes(TextureFormat::bc3, 1) == 16);
  CHECK(texture_chain_bytes(TextureFormat::bc1, 8) == 32 + 8 + 8 + 8);
}

TEST_CASE("a texture block gives back its tile in every format and size") {
  for (const TextureFormat format : {TextureFormat::bc1, TextureFormat::bc3, TextureFormat::bc7}) {
    for (const int size : {256, 512}) {
      const TextureTile tile = some_tile(format, size);
      const auto back = decode_texture_block(encode_texture_block(tile), size);
      REQUIRE(back.ok());
      CHECK(back->format == format);
      CHECK(back->texels == tile.texels);
    }
  }
}

TEST_CASE("a texture block of another size, cut, with bytes left over or with reserved bits is refused") {
  auto block = encode_texture_block(some_tile(TextureFormat::bc1, 256));
  CHECK_FALSE(decode_texture_block(block, 512).ok());
  for (std::size_t length = 0; length < block.size(); length += length < 100 ? 1 : 101) {
    const std::vector<std::byte> prefix(block.begin(), block.begin() + static_cast<std::ptrdiff_t>(length));
    REQUIRE_FALSE(decode_texture_block(prefix, 256).ok());
  }
  for (std::size_t at = 0; at < 4; ++at) {
    auto damaged = block;
    damaged[at] = std::byte{4};
    CHECK_FALSE(decode_texture_block(damaged, 256).ok());
  }
  block.push_back(std::byte{0});
  CHECK_FALSE(decode_texture_block(block, 256).ok());
}

}  // namespace cairn
