#include "format/index_page.h"

#include <algorithm>
#include <random>

#include <catch2/catch.hpp>

#include "format/tile_number.h"

namespace cairn {
namespace {

std::vector<IndexEntry> random_entries(std::size_t count, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<IndexEntry> entries;
  while (entries.size() < count) {
    IndexEntry e;
    e.layer = static_cast<Layer>(random() % kLayers);
    const int level = static_cast<int>(random() % 30) - 9;
    e.id = {level, static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(tiles_around(level))),
            static_cast<std::int32_t>(random() % static_cast<std::uint32_t>(tiles_pole_to_pole(level)))};
    e.min_quanta = static_cast<std::int32_t>(random());
    e.max_quanta = e.min_quanta;
    e.geometric_error_m = static_cast<float>(random()) / 7;
    e.filled = static_cast<std::uint16_t>(random());
    if (random() % 4 == 0) {
      e.flags = kConstant;
    } else {
      if (e.layer == Layer::heights)
        e.max_quanta = std::max(e.min_quanta, static_cast<std::int32_t>(random()));
      if (e.layer != Layer::heights) e.max_quanta = static_cast<std::int32_t>(random());
      e.flags = random() % 3 == 0 ? kSharedBlock : 0;
      e.offset = kPackStartBytes + (std::uint64_t{random()} << 20);
      e.bytes = 1 + static_cast<std::uint32_t>(random() % 1000000);
      e.checksum = std::uint64_t{random()} << 32 | random();
    }
    entries.push_back(e);
  }
  const auto before = [](const IndexEntry& a, const IndexEntry& b) {
    return index_key_of(a) < index_key_of(b);
  };
  std::sort(entries.begin(), entries.end(), before);
  const auto same = [](const IndexEntry& a, const IndexEntry& b) {
    return index_key_of(a) == index_key_of(b);
  };
  entries.erase(std::unique(entries.begin(), entries.end(), same), entries.end());
  return entries;
}

}  // namespace

TEST_CASE("tile numbers: a level follows the one above, children stand together, and back again") {
  std::uint64_t next = 0;
  for (int level = kMinLevel; level <= kMaxLevel; ++level) {
    CHECK(tile_number({level, 0, 0}) == next);
    next += std::uint64_t{1} << 2 * (level + 9);
    const TileId last{level, tiles_around(level) - 1, tiles_pole_to_pole(level) - 1};
    CHECK(tile_number(last) < next);
    CHECK(tile_of_number(tile_number(last)) == last);
  }
  CHECK_FALSE(tile_of_number(next));
  CHECK_FALSE(tile_of_number(tile_number({2, 0, 0}) + (std::uint64_t{1} << 22) - 1));  // beyond 180°
  for (const TileId& id : {TileId{-9, 0, 0}, TileId{0, 207, 126}, TileId{19, 188743679, 94371839}}) {
    const std::uint64_t first = tile_number(child_of(id, 0));
    for (int q = 0; q < 4; ++q) {
      if (is_valid(child_of(id, q)))
        CHECK(tile_number(child_of(id, q)) == first + static_cast<std::uint64_t>(q));
    }
  }
  for (std::int32_t x = 0; x < 300; ++x) {
    for (std::int32_t y = 0; y < 120; y += 7)
      CHECK(tile_of_number(tile_number({0, x, y})) == TileId{0, x, y});
  }
  CHECK(tile_of_key(index_key_of(Layer::water, {2, 5, 7}))->layer == Layer::water);
  CHECK_FALSE(tile_of_key(std::uint64_t{kLayers} << 59));
  CHECK(index_key_of(Layer::heights, {20, 300'000'000, 188'000'000}) <
        index_key_of(Layer::imagery, {-9, 0, 0}));
}

TEST_CASE("pages come back as they were written") {
  for (const std::size_t count : {1u, 2u, 100u, 1024u}) {
    const auto entries = random_entries(count, static_cast<std::uint32_t>(count));
    const auto page = decode_index_page(encode_leaf_page(entries));
    REQUIRE(page.ok());
    CHECK(page->height == 0);
    CHECK(page->entries == entries);
    for (std::size_t i = 0; i < entries.size(); ++i) CHECK(page->keys[i] == index_key_of(entries[i]));
  }
  CHECK(decode_index_page(encode_leaf_page({}))->entries.empty());
  const std::vector<ChildPage> children{
      {5, 700, 20000, 9000, 1}, {6, 1, 29000, 1, UINT64_MAX}, {UINT64_MAX, 3, 16384, 16384, 0}};
  const auto page = decode_index_page(encode_branch_page(3, children));
  REQUIRE(page.ok());
  CHECK(page->height == 3);
  CHECK(page->children == children);
}

TEST_CASE("a planet's entries take some twenty bytes each in a page") {
  std::mt19937 random(1);
  std::vector<IndexEntry> entries;
  std::uint64_t offset = 123456789;
  for (std::int32_t i = 0; i < 768; ++i) {
    IndexEntry e;
    e.id = {3, 1000 + i % 32, 500 + i / 32};
    e.bytes = 90000 + static_cast<std::uint32_t>(random() % 60000);
    e.checksum = std::uint64_t{random()} << 32 | random();
    e.min_quanta = static_cast<std::int32_t>(2000 + random() % 800);
    e.max_quanta = e.min_quanta + static_cast<std::int32_t>(random() % 2000);
    e.geometric_error_m = 0.2f + static_cast<float>(random() % 1000000) * 3e-7f;
    entries.push_back(e);
  }
  std::sort(entries.begin(), entries.end(),
            [](const auto& a, const auto& b) { return index_key_of(a) < index_key_of(b); });
  for (std::size_t i = 0; i < entries.size(); ++i) {
    if (i % 4 == 0) offset += 100000;  // a parent's block
    entries[i].offset = offset;
    offset += entries[i].bytes;
  }
  const std::size_t bytes = encode_leaf_page(entries).size();
  INFO(bytes);
  CHECK(bytes <= kMostPageBytes);
}

TEST_CASE("every prefix of a page, bytes left over and rows out of order are refused") {
  const auto good = encode_leaf_page(random_entries(20, 3));
  for (std::size_t length = 0; length < good.size(); ++length)
    CHECK_FALSE(decode_index_page(std::span(good).first(length)).ok());
  auto longer = good;
  longer.push_back(std::byte{0});
  CHECK_FALSE(decode_index_page(longer).ok());
  const auto with = [&](std::size_t at, unsigned value) {
    auto bytes = good;
    bytes[at] = static_cast<std::byte>(value);
    return decode_index_page(bytes);
  };
  CHECK_THAT(with(0, 8).error().message, Catch::Contains("height"));
  CHECK_FALSE(with(0, 1).ok());
  CHECK_THAT(with(1, 1).error().message, Catch::Contains("reserved"));
  CHECK_THAT(with(3, 255).error().message, Catch::Contains("1024 rows"));
  auto entries = random_entries(20, 3);
  std::swap(entries[4], entries[5]);
  CHECK_THAT(decode_index_page(encode_leaf_page(entries)).error().message, Catch::Contains("ascend"));
  const std::vector<ChildPage> empty_child{{5, 0, 20000, 9000, 1}}, large{{5, 1, 20000, 16385, 1}};
  CHECK_THAT(decode_index_page(encode_branch_page(1, empty_child)).error().message,
             Catch::Contains("entries"));
  CHECK_THAT(decode_index_page(encode_branch_page(1, large)).error().message, Catch::Contains("16384 bytes"));
}

TEST_CASE("a root comes back as it was written, and refuses levels that are none") {
  const std::vector<PackLevel> levels{{Layer::heights, -9, 3.5f, 1, 0, 77},
                                      {Layer::heights, 20, 0.0f, 3, 3, 0},
                                      {Layer::water, 0, 0.0f, 9, 1, 5}};
  const auto entries = random_entries(30, 5);
  const auto good = encode_root(levels, encode_leaf_page(entries));
  const auto root = decode_root(good);
  REQUIRE(root.ok());
  CHECK(root->levels == levels);
  CHECK(root->page.entries == entries);
  for (std::size_t length = 0; length < good.size(); ++length)
    CHECK_FALSE(decode_root(std::span(good).first(length)).ok());
  const auto refused = [&](auto change) {
    auto changed = levels;
    change(changed);
    return !decode_root(encode_root(changed, encode_leaf_page(entries))).ok();
  };
  CHECK(refused([](auto& l) { std::swap(l[0], l[1]); }));
  CHECK(refused([](auto& l) { l[1] = l[0]; }));
  CHECK(refused([](auto& l) { l[0].level = -10; }));
  CHECK(refused([](auto& l) { l[2].level = 21; }));
  CHECK(refused([](auto& l) { l[2].layer = static_cast<Layer>(6); }));
  CHECK(refused([](auto& l) { l[0].tiles = 0; }));
  CHECK(refused([](auto& l) { l[0].constant_tiles = 2; }));
  CHECK(refused([](auto& l) { l[0].max_error_m = -1; }));
}

}  // namespace cairn
