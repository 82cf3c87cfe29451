#include "format/height_block.h"

#include <limits>

#include <catch2/catch.hpp>

#include "tests/support/test_pack.h"

namespace cairn {
namespace {

using test::TestSurface;

const TestSurface kHills{257, 2, test::hills, {}};
const TestSurface kHoles{257, 2, test::hills, [](auto c, auto r) { return (c * c + r * r) % 97 < 30; }};
const TileId kTile{2, 7, 11};

}  // namespace

TEST_CASE("a height block gives back its tile with every codec, with voids and without") {
  for (const HeightCodec* codec : height_codecs()) {
    for (const TestSurface& surface : {kHills, kHoles}) {
      const HeightTile tile = surface.tile(kTile);
      const auto block = encode_height_block(tile, *codec);
      const Result<HeightTile> back = decode_height_block(block, 257);
      INFO(codec->name);
      REQUIRE(back.ok());
      CHECK(back->size == 257);
      CHECK(back->samples == tile.samples);
      CHECK(back->voids == tile.voids);
    }
  }
}

TEST_CASE("a mask without a void is not stored") {
  HeightTile tile = kHills.tile(kTile);
  const auto plain = encode_height_block(tile, *height_codecs().front());
  tile.voids.assign(tile.samples.size(), 0);
  CHECK(encode_height_block(tile, *height_codecs().front()) == plain);
}

TEST_CASE("a height block of another size, cut or with bytes left over is refused") {
  for (const HeightCodec* codec : height_codecs()) {
    INFO(codec->name);
    auto block = encode_height_block(kHoles.tile(kTile), *codec);
    CHECK_FALSE(decode_height_block(block, 513).ok());
    for (std::size_t length = 0; length < block.size(); length += length < 2000 ? 1 : 997) {
      const std::vector<std::byte> prefix(block.begin(), block.begin() + static_cast<std::ptrdiff_t>(length));
      REQUIRE_FALSE(decode_height_block(prefix, 257).ok());
    }
    block.push_back(std::byte{0});
    CHECK_FALSE(decode_height_block(block, 257).ok());
  }
}

TEST_CASE("a tile whose samples are all multiples of a step is coded in steps, without loss") {
  for (const HeightCodec* codec : height_codecs()) {
    INFO(codec->name);
    const HeightTile plain = kHills.tile(kTile);
    const std::size_t bytes = encode_height_block(plain, *codec).size();
    for (const std::int32_t step : {2, 25, 1000, 65535}) {
      HeightTile tile = kHoles.tile(kTile);
      if (step != 25) tile.voids.clear();
      for (std::int32_t& sample : tile.samples) sample = (sample - 4000) * step;
      const auto block = encode_height_block(tile, *codec);
      CHECK(std::to_integer<int>(block[2]) + 256 * std::to_integer<int>(block[3]) == step);
      const auto back = decode_height_block(block, 257);
      REQUIRE(back.ok());
      CHECK(back->samples == tile.samples);
      CHECK(back->voids == tile.voids);
      if (tile.voids.empty()) CHECK(block.size() <= bytes + 16);
    }
  }
  HeightTile wide{257, std::vector<std::int32_t>(257 * 257, 0), {}};
  wide.samples[5] = 70000;  // no step of 16 bits
  wide.samples[6] = std::numeric_limits<std::int32_t>::min();
  const auto back = decode_height_block(encode_height_block(wide, *height_codecs().front()), 257);
  REQUIRE(back.ok());
  CHECK(back->samples == wide.samples);
}

TEST_CASE("a step of 0, or one that makes samples too large, is refused") {
  HeightTile tile = kHills.tile(kTile);
  tile.samples[7] = 1 << 30;
  tile.samples[8] = 1;
  auto block = encode_height_block(tile, *height_codecs().front());
  block[2] = std::byte{0};
  CHECK_THAT(decode_height_block(block, 257).error().message, Catch::Contains("step"));
  block[2] = std::byte{4};
  CHECK_THAT(decode_height_block(block, 257).error().message, Catch::Contains("32 bits"));
}

TEST_CASE("reserved bits and unknown codecs of a height block are refused") {
  const auto block = encode_height_block(kHills.tile(kTile), *height_codecs().front());
  auto damaged = block;
  damaged[1] = std::byte{2};
  CHECK_FALSE(decode_height_block(damaged, 257).ok());
  auto unknown = block;
  unknown[0] = std::byte{250};
  const auto result = decode_height_block(unknown, 257);
  REQUIRE_FALSE(result.ok());
  CHECK(result.error().code == ErrorCode::bad_data);
  CHECK_THAT(result.error().message, Catch::Contains("250"));
}

}  // namespace cairn
