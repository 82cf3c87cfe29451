// Blocks of objects and of models: round trips, every cut, bytes changed before the frame, and what must not
// be.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <random>

#include <catch2/catch.hpp>

#include "cairn/object_model.h"
#include "cairn/object_tile.h"
#include "format/bytes.h"
#include "format/column_codec.h"
#include "format/zstd_frame.h"
#include "tests/support/test_objects.h"

namespace cairn {
namespace {

using Bytes = std::vector<std::byte>;

constexpr std::array<std::uint16_t, 2> kEnds = {0, 65535};

Bytes start_of(const Bytes& bytes, std::size_t length) {
  return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)};
}

/// A block of objects around any columns.
Bytes block_around(std::uint32_t objects, std::uint32_t models, const ColumnWriter& columns) {
  Bytes block;
  ByteWriter out(block);
  out.write(objects);
  out.write(models);
  out.write(std::int32_t{0});
  out.write(std::int32_t{0});
  out.write(static_cast<std::uint32_t>(columns.bytes().size()));
  append_zstd_frame(columns.bytes(), {.level = 1}, block);
  return block;
}

/// Columns of objects at places along the Z curve, all of scale `scale`.
ColumnWriter columns_of(const std::vector<std::uint64_t>& models, const std::vector<std::uint64_t>& counts,
                        const std::vector<std::uint64_t>& places, std::uint16_t scale = 4096) {
  ColumnWriter columns;
  for (const auto& numbers : {models, counts, places})
    for (const std::uint64_t number : numbers) columns.number(number);
  for (std::size_t i = 0; i < places.size(); ++i) columns.difference(0);
  for (std::size_t i = 0; i < places.size(); ++i) columns.half(0);
  for (std::size_t i = 0; i < places.size(); ++i) columns.half(scale);
  return columns;
}

/// How the block of a changed model is refused; empty where it is not.
std::string model_refusal(const std::function<void(Bytes&)>& edit) {
  Bytes block = encode_model_block(test::box_model("house", 10, 6));
  edit(block);
  const auto model = decode_model_block(block);
  return model ? "" : model.error().message;
}

template <class T>
void put(Bytes& bytes, std::size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

}  // namespace

TEST_CASE("a block of objects gives back its tile, bit for bit") {
  for (const std::size_t count : {1u, 2u, 7u, 1000u, 20000u}) {
    for (const std::uint16_t models : std::initializer_list<std::uint16_t>{1, 3, 30}) {
      const ObjectTile tile = test::random_objects(count, models, static_cast<unsigned>(count));
      const Bytes block = encode_object_block(tile);
      const auto back = decode_object_block(block);
      REQUIRE(back.ok());
      CHECK(*back == tile);
      CHECK(encode_object_block(*back) == block);
    }
  }
}

TEST_CASE("the extremes of every field come back, and so do equal objects") {
  ObjectTile tile{std::numeric_limits<std::int32_t>::min(), std::numeric_limits<std::int32_t>::max(), {}};
  for (const std::uint16_t model : kEnds) {
    for (const std::uint16_t place : kEnds) {
      for (const std::int32_t height : {tile.lowest_quanta, tile.highest_quanta, 0})
        tile.objects.push_back({height, model, place, place, place, std::max<std::uint16_t>(place, 1)});
    }
  }
  tile.objects.push_back(tile.objects.front());
  sort_objects(tile.objects);
  const auto back = decode_object_block(encode_object_block(tile));
  REQUIRE(back.ok());
  CHECK(*back == tile);
}

TEST_CASE("a block of objects takes at most 10 bytes for each before compression where they are many") {
  const ObjectTile tile = test::random_objects(20000, 30, 4);
  const Bytes block = encode_object_block(tile);
  ByteReader in(block);
  for (int i = 0; i < 4; ++i) (void)in.read<std::uint32_t>();
  CHECK(in.read<std::uint32_t>() <= 10 * tile.objects.size());
}

TEST_CASE("a block of objects that is cut, continued or has a changed byte before its frame is refused") {
  const ObjectTile tile = test::random_objects(50, 3, 1);
  Bytes block = encode_object_block(tile);
  for (std::size_t length = 0; length < block.size(); ++length)
    REQUIRE_FALSE(decode_object_block(start_of(block, length)).ok());
  for (const std::size_t at : {0u, 3u, 4u, 7u, 16u, 19u}) {
    Bytes damaged = block;
    damaged[at] ^= std::byte{0x81};
    INFO("byte " << at);
    CHECK_FALSE(decode_object_block(damaged).ok());
  }
  block.push_back(std::byte{0});
  CHECK_FALSE(decode_object_block(block).ok());
}

TEST_CASE("a flipped bit of a block of objects crashes nothing, and what decodes is in order") {
  const Bytes block = encode_object_block(test::random_objects(200, 5, 2));
  for (std::size_t bit = 0; bit < block.size() * 8; ++bit) {
    Bytes damaged = block;
    damaged[bit / 8] ^= std::byte{1} << (bit % 8);
    const auto tile = decode_object_block(damaged);
    if (!tile) continue;
    ObjectTile sorted = *tile;
    sort_objects(sorted.objects);
    REQUIRE(sorted == *tile);
  }
}

TEST_CASE("a block of objects that breaks a rule is refused by a line that says which") {
  const auto refusal = [](std::uint32_t objects, std::uint32_t models, const ColumnWriter& columns) {
    const auto tile = decode_object_block(block_around(objects, models, columns));
    return tile ? std::string() : tile.error().message;
  };
  using Catch::Matchers::Contains;
  CHECK(refusal(2, 1, columns_of({0}, {2}, {1, 2})).empty());
  CHECK_THAT(refusal(0, 0, columns_of({}, {}, {})), Contains("objects: expected 1 to"));
  CHECK_THAT(refusal(2, 3, columns_of({0}, {2}, {1, 2})), Contains("models: expected 1 to 2"));
  CHECK_THAT(refusal(2, 2, columns_of({1, 0}, {1, 1}, {1, 2})), Contains("numbers that ascend"));
  CHECK_THAT(refusal(2, 1, columns_of({65536}, {2}, {1, 2})), Contains("a number below 65536"));
  CHECK_THAT(refusal(2, 1, columns_of({0}, {3}, {1, 2})), Contains("objects of a model"));
  CHECK_THAT(refusal(2, 1, columns_of({0}, {1}, {1, 2})), Contains("objects of all models"));
  CHECK_THAT(refusal(2, 1, columns_of({0}, {2}, {UINT32_MAX, 2})), Contains("below 2^32"));
  CHECK_THAT(refusal(2, 1, columns_of({0}, {2}, {1, 2}, 0)), Contains("a scale above 0"));
  CHECK_THAT(refusal(1, 1, columns_of({0}, {1}, {1, 2})), Contains("column"));
  CHECK_THAT(refusal(3, 1, columns_of({0}, {3}, {1, 2})), Contains("column"));
}

TEST_CASE("an object lies inside its tile, at half a step from its edges at least") {
  for (const TileId id : {TileId{5, 100, 200}, TileId{0, 359, 179}, TileId{-9, 0, 0}}) {
    const GeoBounds bounds = tile_bounds(id);
    for (const std::uint16_t place : kEnds) {
      const LonLat at = place_of(id, {.x = place, .y = place});
      CHECK(at.lon == bounds.west + (place + 0.5) / 65536 * tile_width_degrees(id.level));
      CHECK((at.lon > bounds.west && at.lon < bounds.east && at.lat > bounds.south && at.lat < bounds.north));
    }
  }
}

TEST_CASE("an object's level is the coarsest whose tiles are at most 512 times as high") {
  const Body earth;
  for (double size = 0.0001; size < 1e8; size *= 1.37) {
    const int level = object_level(size, earth);
    const auto fits = [&](int l) {
      return size * 512 >= tile_width_degrees(l) * earth.shape.equator_degree_m();
    };
    CHECK((level == kMaxLevel || fits(level)));
    CHECK((level == kMinLevel || !fits(level - 1)));
  }
}

TEST_CASE("a model comes back within the steps of its block, and then bit for bit") {
  for (const ObjectModel& model : {test::box_model("house", 10, 6), test::picture_model("arbre é", 4, 9)}) {
    const Bytes block = encode_model_block(model);
    const auto back = decode_model_block(block);
    REQUIRE(back.ok());
    CHECK(back->name == model.name);
    CHECK(back->indices == model.indices);
    CHECK(back->levels == model.levels);
    CHECK(back->texture.texels == model.texture.texels);
    CHECK(back->billboard.texels == model.billboard.texels);
    CHECK(back->billboard_views == model.billboard_views);
    CHECK(back->size_m() == Approx(model.size_m()).epsilon(1e-4));
    REQUIRE(back->vertices.size() == model.vertices.size());
    for (std::size_t v = 0; v < model.vertices.size(); ++v) {
      for (std::size_t i = 0; i < 3; ++i) {
        CHECK(std::abs(back->vertices[v].position_m[i] - model.vertices[v].position_m[i]) < 10 / 32767.0f);
        CHECK(std::abs(back->vertices[v].normal[i] - model.vertices[v].normal[i]) < 0.01f);
      }
    }
    CHECK(encode_model_block(*back) == block);
  }
}

TEST_CASE("every packed normal keeps its bits when it is packed again, and every direction its place") {
  ObjectModel model = test::box_model("ball", 2, 2);
  std::mt19937 random(9);
  std::normal_distribution<float> any;
  for (int i = 0; i < 500; ++i) {
    for (ModelVertex& vertex : model.vertices) {
      float length = 0;
      for (float& n : vertex.normal) n = any(random);
      for (const float n : vertex.normal) length += n * n;
      for (float& n : vertex.normal) n /= std::sqrt(length);
    }
    const Bytes block = encode_model_block(model);
    const auto back = decode_model_block(block);
    REQUIRE(back.ok());
    REQUIRE(encode_model_block(*back) == block);
    for (std::size_t v = 0; v < model.vertices.size(); ++v) {
      float cosine = 0;
      for (std::size_t k = 0; k < 3; ++k) cosine += back->vertices[v].normal[k] * model.vertices[v].normal[k];
      REQUIRE(cosine > 0.9998f);
    }
  }
}

TEST_CASE("a block of a model that is cut or continued is refused") {
  for (const ObjectModel& model : {test::box_model("house", 10, 6), test::picture_model("tree", 4, 9)}) {
    Bytes block = encode_model_block(model);
    for (std::size_t length = 0; length < block.size(); ++length)
      REQUIRE_FALSE(decode_model_block(start_of(block, length)).ok());
    block.push_back(std::byte{0});
    CHECK_FALSE(decode_model_block(block).ok());
  }
}

TEST_CASE("a flipped bit of a model's block crashes nothing, and what decodes has all its vertices") {
  const Bytes block = encode_model_block(test::box_model("house", 10, 6));
  for (std::size_t bit = 0; bit < block.size() * 8; ++bit) {
    Bytes damaged = block;
    damaged[bit / 8] ^= std::byte{1} << (bit % 8);
    const auto model = decode_model_block(damaged);
    if (!model) continue;
    for (const std::uint16_t index : model->indices) REQUIRE(index < model->vertices.size());
    for (const ModelLevel& level : model->levels) REQUIRE(level.first + level.count <= model->indices.size());
    REQUIRE(std::isfinite(model->size_m()));
  }
}

TEST_CASE("a model's block that breaks a rule is refused by a line that says which") {
  using Catch::Matchers::Contains;
  const auto nan = std::numeric_limits<float>::quiet_NaN();
  CHECK(model_refusal([](Bytes&) {}).empty());
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 2, std::uint8_t{9}); }),
             Contains("levels: expected at most 8"));
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 2, std::uint8_t{0}); }),
             Contains("levels: expected vertices"));
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 3, std::uint8_t{1}); }),
             Contains("billboard views: expected 8"));
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 4, UINT32_MAX); }), Contains("indices: expected at most"));
  CHECK_THAT(model_refusal([&](Bytes& b) { put(b, 8, nan); }), Contains("bounds: expected finite"));
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 12, 99.0f); }),
             Contains("bounds: expected those of the vertices"));
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 16, 99.0f); }), Contains("bottom not above top"));
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 24, std::uint8_t{2}); }),
             Contains("texture: expected format"));
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 25, std::uint8_t{13}); }),
             Contains("texture: expected a width"));
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 28, std::uint8_t{0}); }), Contains("name"));
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 30, std::uint8_t{1}); }), Contains("reserved"));
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 37, std::uint32_t{4}); }), Contains("3 per triangle"));
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 41, 1.0f); }), Contains("error of level 0: expected 0 m"));
  CHECK_THAT(model_refusal([](Bytes& b) { put(b, 45, std::uint32_t{3}); }),
             Contains("indices of all levels"));
  CHECK_THAT(model_refusal([&](Bytes& b) { put(b, 49, nan); }), Contains("error of level 1"));
}

}  // namespace cairn
