// Any bytes are decoded as the block of a height tile, of a texture tile, of objects and of a model.

#include <catch2/catch.hpp>

#include "cairn/object_model.h"
#include "cairn/object_tile.h"
#include "cairn/texture_tile.h"
#include "format/height_block.h"
#include "tests/support/fuzz.h"
#include "tests/support/test_objects.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

void height_block(std::span<const std::byte> input) {
  const auto tile = decode_height_block(input, 257);
  if (tile) REQUIRE(tile->samples.size() == 257 * 257);
}

void texture_block(std::span<const std::byte> input) {
  const auto tile = decode_texture_block(input, 256);
  if (tile) REQUIRE(tile->texels.size() == texture_chain_bytes(tile->format, 256));
}

void object_block(std::span<const std::byte> input) {
  auto tile = decode_object_block(input);
  if (!tile) return;
  const auto back = decode_object_block(encode_object_block(*tile));
  REQUIRE((back.ok() && *back == *tile));
}

void model_block(std::span<const std::byte> input) {
  const auto model = decode_model_block(input);
  if (!model) return;
  for (const std::uint16_t index : model->indices) REQUIRE(index < model->vertices.size());
}

}  // namespace

TEST_CASE("no bytes make decoding a height tile crash, in any codec") {
  const test::TestSurface plain{257, 2, test::hills, {}};
  const test::TestSurface holes{257, 2, test::hills,
                                [](auto c, auto r) { return (c * c + r * r) % 97 < 30; }};
  std::vector<std::vector<std::byte>> seeds;
  for (const HeightCodec* codec : height_codecs()) {
    for (const auto& surface : {plain, holes}) {
      seeds.push_back(encode_height_block(surface.tile({2, 8, 4}), *codec));
    }
  }
  test::run_fuzz("height_block", height_block, seeds, 5000);
}

TEST_CASE("no bytes make decoding a texture tile crash") {
  std::vector<std::vector<std::byte>> seeds;
  for (const TextureFormat format : {TextureFormat::bc1, TextureFormat::bc3, TextureFormat::bc7}) {
    TextureTile tile{format, 256, {}};
    tile.texels.resize(texture_chain_bytes(format, 256));
    for (std::size_t i = 0; i < tile.texels.size(); i += 37) tile.texels[i] = static_cast<std::byte>(i);
    seeds.push_back(encode_texture_block(tile));
  }
  test::run_fuzz("texture_block", texture_block, seeds, 5000);
}

TEST_CASE("no bytes make decoding objects or a model crash") {
  std::vector<std::vector<std::byte>> objects;
  for (const std::size_t count : {1u, 40u, 500u})
    objects.push_back(encode_object_block(test::random_objects(count, 6, 3)));
  test::run_fuzz("object_block", object_block, objects, 20000);
  test::run_fuzz("model_block", model_block,
                 {encode_model_block(test::box_model("house", 10, 6)),
                  encode_model_block(test::picture_model("tree", 4, 9))},
                 20000);
}

}  // namespace cairn
