// A test for every finding that verify_pack can report: each breaks one rule and looks for its words.

#include "format/pack_verify.h"

#include <algorithm>

#include <catch2/catch.hpp>

#include "cairn/pack_reader.h"
#include "cairn/texture_tile.h"
#include "format/checksum.h"
#include "format/height_block.h"
#include "format/index_page.h"
#include "format/pack_writer.h"
#include "tests/support/test_data.h"
#include "tests/support/test_objects.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

const test::TestSurface kHills{257, 2, test::hills, {}};
const test::TestSurface kHoles{257, 2, test::hills, [](auto c, auto r) { return (c * c + r * r) % 97 < 30; }};

using Edit = std::function<void(IndexEntry&, HeightTile&)>;

VerifyReport verify(const fs::path& path, int threads = 1) {
  const auto report = verify_pack(path, {threads, 1000});
  REQUIRE(report.ok());
  for (const Finding& finding : report->findings) UNSCOPED_INFO(finding.where << ": " << finding.what);
  return *report;
}

bool finds(const VerifyReport& report, const std::string& where, const std::string& what) {
  return std::any_of(report.findings.begin(), report.findings.end(), [&](const Finding& finding) {
    return finding.where == where && finding.what.find(what) != std::string::npos;
  });
}

/// The findings of a pack whose tile `id` was edited, its entry or its samples.
VerifyReport verify_edited(const std::vector<TileId>& tiles, const TileId& id, const Edit& edit,
                           const test::TestSurface& surface = kHills) {
  const test::TempDir dir;
  test::write_test_pack(dir.path() / "a.cairn", surface, tiles, [&](IndexEntry& entry, HeightTile& tile) {
    if (entry.id == id) edit(entry, tile);
  });
  return verify(dir.path() / "a.cairn");
}

void set(HeightTile& tile, int column, int row, std::int32_t value) {
  tile.samples[static_cast<std::size_t>(row) * static_cast<std::size_t>(tile.size) +
               static_cast<std::size_t>(column)] = value;
}

void set_void(HeightTile& tile, int column, int row) {
  if (tile.voids.empty()) tile.voids.resize(tile.samples.size());
  tile.voids[static_cast<std::size_t>(row) * static_cast<std::size_t>(tile.size) +
             static_cast<std::size_t>(column)] = 1;
}

/// Writes a pack of raw blocks, none of them checked.
fs::path raw_pack(const test::TempDir& dir,
                  const std::vector<std::pair<IndexEntry, std::vector<std::byte>>>& tiles,
                  std::string_view metadata = "{}") {
  Result<PackWriter> writer = PackWriter::create(dir.path() / "raw.cairn", test::test_header());
  REQUIRE(writer.ok());
  for (const auto& [entry, block] : tiles) REQUIRE(writer->add(entry, block).ok());
  REQUIRE(writer->finish(metadata).ok());
  return dir.path() / "raw.cairn";
}

/// Puts another root, which follows the header, into a pack.
void put_root(std::vector<std::byte>& bytes, PackHeader header, std::span<const std::byte> root) {
  std::fill(bytes.begin() + kPackHeaderBytes, bytes.begin() + kPackStartBytes, std::byte{0});
  std::copy(root.begin(), root.end(), bytes.begin() + kPackHeaderBytes);
  header.root_bytes = static_cast<std::uint32_t>(root.size());
  header.root_checksum = checksum(std::span(bytes).first(kPackStartBytes).subspan(kPackHeaderBytes));
  const auto encoded = encode_header(header);
  std::copy(encoded.begin(), encoded.end(), bytes.begin());
}

PackHeader header_of(const std::vector<std::byte>& bytes) {
  return *decode_header(std::span(bytes).first(kPackHeaderBytes));
}

/// Rewrites the index of a pack, all of which is in its root, and the checksums over it.
void edit_index(const fs::path& path, const std::function<void(PackRoot&)>& edit) {
  auto bytes = test::read_bytes(path);
  const PackHeader header = header_of(bytes);
  PackRoot root = *decode_root(std::span(bytes).subspan(kPackHeaderBytes, header.root_bytes));
  REQUIRE(root.page.height == 0);
  edit(root);
  put_root(bytes, header, encode_root(root.levels, encode_leaf_page(root.page.entries)));
  test::write_bytes(path, bytes);
}

/// A pack of hills with objects in one tile and two models, and what an edit makes of it.
struct ObjectPack {
  ObjectTile tile;
  IndexEntry objects;
  std::vector<ObjectModel> models;
  std::vector<IndexEntry> model_entries;
};

VerifyReport verify_objects(const std::function<void(ObjectPack&)>& edit) {
  const TileId id{2, 8, 4};
  ObjectPack pack;
  pack.models = {test::box_model("hill", 30, 60), test::picture_model("tree", 30, 55)};
  pack.models[0] = *decode_model_block(encode_model_block(pack.models[0]));
  const test::TestSurface flat{
      257, 2, [](auto c, auto r) { return static_cast<std::int32_t>((c + r) % 2); }, {}};
  const test::TempDir dir;
  auto writer = PackWriter::create(dir.path() / "o.cairn", test::test_header());
  REQUIRE(writer.ok());
  const HeightTile ground = flat.tile(id);
  REQUIRE(writer->add(test::describe(id, ground), encode_height_block(ground, *height_codecs()[0])).ok());
  pack.tile.objects = {{0, 0, 128, 128, 0, 4096}, {8, 1, 128, 40000, 9, 4096}};
  // Both stand just beyond the middle between samples of 0 and 1: below ½ in the first cell, above in the other.
  pack.tile.lowest_quanta = 0;
  pack.tile.highest_quanta = 9;
  pack.objects.layer = Layer::objects;
  pack.objects.id = id;
  pack.objects.min_quanta = 2;
  pack.objects.geometric_error_m = pack.models[0].size_m();
  for (std::size_t m = 0; m < 2; ++m) {
    IndexEntry entry;
    entry.layer = Layer::models;
    entry.id = model_address(static_cast<std::uint32_t>(m));
    entry.geometric_error_m = pack.models[m].size_m();
    entry.min_quanta = m == 0 ? 10 : 0;
    pack.model_entries.push_back(entry);
  }
  edit(pack);
  REQUIRE(writer->add(pack.objects, encode_object_block(pack.tile)).ok());
  for (std::size_t m = 0; m < pack.models.size(); ++m)
    REQUIRE(writer->add(pack.model_entries[m], encode_model_block(pack.models[m])).ok());
  REQUIRE(writer->finish("{}").ok());
  return verify(dir.path() / "o.cairn");
}

const std::vector<TileId> kFour = test::with_ancestors({{2, 8, 4}, {2, 9, 4}, {2, 8, 5}, {2, 9, 5}}, 0);

}  // namespace

TEST_CASE("a good pack has no findings: heights with and without voids, with 1 to 4 threads") {
  const test::TempDir dir;
  for (const auto& surface : {kHills, kHoles}) {
    test::write_test_pack(dir.path() / "a.cairn", surface, test::with_ancestors(kFour, -3));
    for (int threads = 1; threads <= 4; ++threads) CHECK(verify(dir.path() / "a.cairn", threads).ok());
  }
}

TEST_CASE("a good pack that goes around the Earth has no findings at any level", "[slow]") {
  const test::TempDir dir;
  const test::TestSurface surface{257, 0, test::hills, {}};
  for (int level = -9; level <= 0; ++level) {
    const std::int32_t last = tiles_around(level) - 1, top = tiles_pole_to_pole(level) - 1;
    std::vector<TileId> ids{{level, 0, 0}, {level, last, 0}, {level, 0, top}, {level, last, top}};
    ids = test::with_ancestors(ids, -9);
    test::write_test_pack(dir.path() / "a.cairn", surface, ids);
    INFO("level " << level);
    CHECK(verify(dir.path() / "a.cairn", 2).ok());
  }
}

TEST_CASE("a pack that is not there is an error, not a finding") {
  const auto report = verify_pack("/nowhere/a.cairn");
  REQUIRE_FALSE(report.ok());
  CHECK(report.error().code == ErrorCode::failed);
}

TEST_CASE("verify finds a file that is no pack, or cut") {
  const test::TempDir dir;
  test::write_test_pack(dir.path() / "a.cairn", kHills, {{2, 8, 4}});
  fs::resize_file(dir.path() / "a.cairn", 5000);
  CHECK(finds(verify(dir.path() / "a.cairn"), "file", "file size: expected"));
  fs::resize_file(dir.path() / "a.cairn", 50);
  CHECK(finds(verify(dir.path() / "a.cairn"), "file", "header: expected 256 bytes, found 50"));
}

TEST_CASE("verify finds a damaged header, index and metadata") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  test::write_test_pack(path, kHills, {{2, 8, 4}});
  const auto good = test::read_bytes(path);
  const PackHeader header = header_of(good);
  const std::pair<std::uint64_t, const char*> places[] = {{20, "header: checksum"},
                                                          {kPackHeaderBytes + 9, "root: checksum"},
                                                          {kPackStartBytes - 1, "root: checksum"},
                                                          {header.metadata_offset + 3, "metadata: checksum"}};
  for (const auto& [at, words] : places) {
    auto bytes = good;
    bytes[at] ^= std::byte{1};
    test::write_bytes(path, bytes);
    CHECK(finds(verify(path), "file", words));
  }
}

TEST_CASE("verify finds index entries that are out of order, out of range or point outside") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  const auto found = [&](const std::function<void(std::vector<IndexEntry>&)>& edit, const char* words) {
    test::write_test_pack(path, kHills, {{2, 8, 4}, {2, 9, 4}});
    edit_index(path, [&](PackRoot& root) { edit(root.page.entries); });
    return finds(verify(path), "file", words);
  };
  CHECK(found([](auto& e) { std::swap(e[0], e[1]); }, "root: expected keys that ascend"));
  CHECK(found([](auto& e) { e[1].id = e[0].id; }, "root: expected keys that ascend"));
  CHECK(found([](auto& e) { e[1].flags = 64; }, "root: heights tile 2/9/4: flags: expected bits"));
  CHECK(found([](auto& e) { e[1].offset += 1; }, "root: heights tile 2/9/4: expected a block before byte"));
  CHECK(found([](auto& e) { e[0].offset = UINT64_MAX; }, "expected a block before byte"));
  CHECK(found([](auto& e) { e.pop_back(); }, "root: expected 2 entries as the header has, found 1"));
}

TEST_CASE("verify finds sums over a level that are not those of its entries") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  const auto found = [&](const std::function<void(PackLevel&)>& edit) {
    test::write_test_pack(path, kHills, {{2, 8, 4}, {2, 9, 4}});
    edit_index(path, [&](PackRoot& root) { edit(root.levels[0]); });
    return finds(verify(path), "root", "expected the sums of the entries for heights level 2");
  };
  CHECK(found([](PackLevel& level) { level.constant_tiles = 1; }));
  CHECK(found([](PackLevel& level) { level.block_bytes += 1; }));
  CHECK(found([](PackLevel& level) { level.max_error_m += 1; }));
  CHECK_FALSE(found([](PackLevel&) {}));
}

TEST_CASE("verify finds a page of the index that is damaged, and bytes of the index in no page", "[slow]") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  auto writer = PackWriter::create(path, test::test_header());
  REQUIRE(writer.ok());
  for (std::int32_t i = 0; i < 3000; ++i) {
    IndexEntry entry;
    entry.flags = kConstant;
    entry.id = {2, i % 60, i / 60};
    REQUIRE(writer->add(entry, {}).ok());
  }
  REQUIRE(writer->finish("{}").ok());
  CHECK(verify(path).ok());
  const auto good = test::read_bytes(path);
  const PackHeader header = header_of(good);
  for (std::uint64_t at = header.index_offset; at < header.metadata_offset; at += 101) {
    auto bytes = good;
    bytes[at] ^= std::byte{1};
    test::write_bytes(path, bytes);
    REQUIRE(finds(verify(path), "index", "checksum: expected"));
  }
  const PackRoot root = *decode_root(std::span(good).subspan(kPackHeaderBytes, header.root_bytes));
  REQUIRE(root.page.height == 1);
  auto bytes = good;
  bytes.insert(bytes.begin() + static_cast<std::ptrdiff_t>(header.metadata_offset), std::byte{0});
  PackHeader longer = header;
  ++longer.metadata_offset;
  put_root(bytes, longer, encode_root(root.levels, encode_branch_page(1, root.page.children)));
  test::write_bytes(path, bytes);
  CHECK(finds(verify(path), "index", "expected each byte in one page, found bytes in none"));
}

TEST_CASE("verify finds metadata that is empty or no UTF-8") {
  const test::TempDir dir;
  CHECK(finds(verify(raw_pack(dir, {}, "")), "metadata", "expected JSON, found nothing"));
  CHECK(verify(raw_pack(dir, {}, "\"\xC3\xA9 \xE2\x9B\xB0 \xF0\x9F\x8F\x94\"")).ok());
  for (const char* text :
       {"ab\x80", "ab\xC3", "ab\xC0\x80", "ab\xED\xA0\x80", "ab\xF4\x90\x80\x80", "ab\xE2\x9Bx"}) {
    CHECK(finds(verify(raw_pack(dir, {}, text)), "metadata", "found another byte at 2"));
  }
}

TEST_CASE("verify finds bytes in no block, and blocks that overlap") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  const std::vector<TileId> two{{2, 8, 4}, {2, 9, 4}};
  test::write_test_pack(path, kHills, two);
  edit_index(path, [](PackRoot& root) { root.page.entries[0].bytes -= 1; });
  CHECK(finds(verify(path), "blocks", "expected each byte in one block, found bytes in none"));
  test::write_test_pack(path, kHills, two);
  edit_index(path, [](PackRoot& root) { root.page.entries[0].bytes += 1; });
  CHECK(finds(verify(path), "blocks", "found blocks that overlap"));
  test::write_test_pack(path, kHills, two);
  edit_index(path, [](PackRoot& root) {
    IndexEntry& e = root.page.entries[1];
    e = {Layer::heights, kConstant, e.id, 0, 0, 0, 5, 5, 1.0f, 0};
  });
  CHECK(finds(verify(path), "blocks", "found bytes in none"));
  test::write_test_pack(path, kHills, two);
  edit_index(path, [](PackRoot& root) { root.page.entries[0].flags |= kSharedBlock; });
  CHECK(finds(verify(path), "blocks", "expected one tile that does not share it, found none"));
}

TEST_CASE("verify finds a block with another checksum, and one that does not decode") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  test::write_test_pack(path, kHills, {{2, 8, 4}});
  auto bytes = test::read_bytes(path);
  bytes[kPackStartBytes + 10] ^= std::byte{64};
  test::write_bytes(path, bytes);
  CHECK(finds(verify(path), "heights 2/8/4", "block: checksum"));
  IndexEntry entry;
  entry.id = {2, 8, 4};
  CHECK(finds(verify(raw_pack(dir, {{entry, {std::byte{251}, {}, {}, {}}}})), "heights 2/8/4", "no codec"));
}

TEST_CASE("verify finds imagery that does not decode, and leaves good imagery alone") {
  const test::TempDir dir;
  IndexEntry entry;
  entry.layer = Layer::imagery;
  entry.id = {2, 8, 4};
  TextureTile tile{TextureFormat::bc1, 256, {}};
  tile.texels.resize(texture_chain_bytes(tile.format, tile.size));
  const auto block = encode_texture_block(tile);
  CHECK(verify(raw_pack(dir, {{entry, block}})).ok());
  CHECK(finds(verify(raw_pack(dir, {{entry, {std::byte{2}, {}, {}, {}}}})), "imagery 2/8/4", "format"));
}

TEST_CASE("verify finds triangulations that do not decode, and damage to their blocks") {
  const test::TempDir dir;
  IndexEntry entry;
  entry.layer = Layer::rqt;
  entry.id = {2, 8, 4};
  const fs::path path = raw_pack(dir, {{entry, std::vector<std::byte>(20, std::byte{7})}});
  CHECK(finds(verify(path), "rqt 2/8/4", "rqt block: expected code 0 or 1"));
  auto bytes = test::read_bytes(path);
  bytes[kPackStartBytes] ^= std::byte{1};
  test::write_bytes(path, bytes);
  CHECK(finds(verify(path), "rqt 2/8/4", "block: checksum"));
}

TEST_CASE("verify finds a minimum, maximum or void flag that the samples do not have") {
  const TileId id{2, 8, 4};
  CHECK(finds(verify_edited({id}, id, [](auto& e, auto&) { e.min_quanta -= 1; }), "heights 2/8/4",
              "minimum: expected"));
  CHECK(finds(verify_edited({id}, id, [](auto& e, auto&) { e.max_quanta += 1; }), "heights 2/8/4",
              "maximum: expected"));
  CHECK(finds(verify_edited({id}, id, [](auto& e, auto&) { e.flags |= kHasVoids; }), "heights 2/8/4",
              "void flag: expected 0"));
  CHECK(finds(verify_edited(
                  {id}, id, [](auto& e, auto&) { e.flags = 0; }, kHoles),
              "heights 2/8/4", "void flag: expected 1"));
}

TEST_CASE("verify finds a tile of equal samples that is not stored as constant") {
  const test::TestSurface flat{257, 2, [](auto, auto) { return 7; }, {}};
  const auto report = verify_edited(
      {{2, 8, 4}}, {2, 8, 4}, [](auto& e, auto&) { e.flags = 0; }, flat);
  CHECK(finds(report, "heights 2/8/4", "expected a constant tile"));
}

TEST_CASE("verify finds a tile without a parent, except at the coarsest level") {
  std::vector<TileId> orphan = kFour;
  orphan.erase(std::find(orphan.begin(), orphan.end(), TileId{1, 4, 2}));
  const auto report = verify_edited(orphan, {0, 0, 0}, {});
  CHECK(finds(report, "heights 2/9/5", "expected its parent 1/4/2, found none"));
  CHECK_FALSE(finds(report, "heights 0/2/1", "parent"));
}

TEST_CASE("verify finds a parent with a smaller error than its child's") {
  const auto report = verify_edited(kFour, {2, 9, 5}, [](auto& e, auto&) { e.geometric_error_m = 500; });
  CHECK(finds(report, "heights 2/9/5", "geometric error: expected no more than its parent's"));
  CHECK(report.findings.size() == 1);
}

TEST_CASE("verify finds a sample that is not its parent's, also where one of them is void") {
  const auto lift = [](IndexEntry& entry, HeightTile& tile) {
    set(tile, 100, 60, tile.at(100, 60) + 1);
    const auto edited = test::describe(entry.id, tile);
    entry.min_quanta = edited.min_quanta;
    entry.max_quanta = edited.max_quanta;
  };
  const auto report = verify_edited(kFour, {2, 9, 5}, lift);
  CHECK(finds(report, "heights 2/9/5", "in its parent 1/4/2; 1 of 16641 samples differ"));
  CHECK(report.findings.size() == 1);
  const auto hole = [](IndexEntry& entry, HeightTile& tile) {
    set_void(tile, 100, 60);
    entry = test::describe(entry.id, tile);
  };
  CHECK(finds(verify_edited(kFour, {2, 9, 5}, hole), "heights 2/9/5", "a void here"));
}

TEST_CASE("what a void sample holds is nobody's business") {
  const auto fill = [](IndexEntry&, HeightTile& tile) {
    for (std::size_t i = 0; i < tile.samples.size(); ++i) {
      if (tile.voids[i] != 0) tile.samples[i] = -100000;
    }
  };
  CHECK(verify_edited(kFour, {2, 9, 5}, fill, kHoles).ok());
}

TEST_CASE("verify finds edges that neighbours do not share, also voids, and counts the samples") {
  const std::vector<TileId> pair{{2, 8, 4}, {2, 9, 4}, {2, 8, 5}};
  const auto lift = [](int column, int row) {
    return [=](IndexEntry& entry, HeightTile& tile) {
      set(tile, column, row, tile.at(column, row) + 1);
      set(tile, column, row + 2, tile.at(column, row + 2) + 1);
      entry = test::describe(entry.id, tile);
    };
  };
  CHECK(finds(
      verify_edited(pair, {2, 9, 4}, lift(0, 31)), "heights 2/8/4",
      "expected its eastern edge in its neighbour 2/9/4; 2 of 257 samples differ, the first is number 31"));
  CHECK(finds(verify_edited(pair, {2, 8, 5}, lift(31, 0)), "heights 2/8/4",
              "expected its northern edge in its neighbour 2/8/5; 1 of 257"));
  const auto hole = [](IndexEntry& entry, HeightTile& tile) {
    set_void(tile, 0, 77);
    entry = test::describe(entry.id, tile);
  };
  CHECK(finds(verify_edited(pair, {2, 9, 4}, hole), "heights 2/8/4", "a void there"));
}

TEST_CASE("verify finds corners that diagonal neighbours do not share when nothing lies between them") {
  const auto lift = [](int column, int row) {
    return [=](IndexEntry& entry, HeightTile& tile) {
      set(tile, column, row, 20000);
      entry = test::describe(entry.id, tile);
    };
  };
  CHECK(finds(verify_edited({{2, 8, 4}, {2, 9, 5}}, {2, 9, 5}, lift(0, 0)), "heights 2/8/4",
              "north-eastern corner in its neighbour 2/9/5"));
  CHECK(finds(verify_edited({{2, 8, 5}, {2, 9, 4}}, {2, 9, 4}, lift(0, 256)), "heights 2/8/5",
              "south-eastern corner in its neighbour 2/9/4"));
}

TEST_CASE("verify finds an antimeridian that differs from its two sides, at every level") {
  const test::TestSurface surface{257, 0, test::hills, {}};
  for (int level = -9; level <= 0; ++level) {
    const TileId west{level, 0, tile_at({0, 10}, level).y};
    const TileId east{level, tiles_around(level) - 1, west.y};
    std::vector<TileId> ids{west, east};
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
    const auto lift = [](IndexEntry& entry, HeightTile& tile) {
      set(tile, 0, 3, tile.at(0, 3) + 1);
      entry = test::describe(entry.id, tile);
    };
    INFO("level " << level);
    CHECK(finds(verify_edited(ids, west, lift, surface), "heights " + to_string(east), "eastern edge"));
  }
}

TEST_CASE("verify finds a height past the world's edge") {
  const test::TestSurface surface{257, 0, test::hills, {}};
  const auto fill = [](int column, int row) {
    return [=](IndexEntry& entry, HeightTile& tile) {
      tile.voids[static_cast<std::size_t>(row * 257 + column)] = 0;
      entry = test::describe(entry.id, tile);
    };
  };
  CHECK(finds(verify_edited({{-9, 0, 0}}, {-9, 0, 0}, fill(181, 20), surface), "heights -9/0/0",
              "sample 181,20: expected a void past the world's edge"));
  CHECK(
      finds(verify_edited({{-9, 0, 0}}, {-9, 0, 0}, fill(5, 91), surface), "heights -9/0/0", "sample 5,91"));
}

TEST_CASE("findings come in the index's order with any number of threads, and no more than asked for") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  test::write_test_pack(path, kHills, kFour, [](IndexEntry& entry, HeightTile&) { entry.min_quanta -= 1; });
  const auto one = verify(path, 1), four = verify(path, 4);
  REQUIRE(one.findings.size() == kFour.size());
  for (std::size_t i = 0; i < kFour.size(); ++i) CHECK(one.findings[i].where == four.findings[i].where);
  CHECK(verify_pack(path, {2, 3})->findings.size() == 3);
}

TEST_CASE("verify finds objects that break a rule, each by its own line") {
  CHECK(verify_objects([](ObjectPack&) {}).ok());
  const std::string tile = "objects 2/8/4";
  CHECK(finds(verify_objects([](ObjectPack& p) { p.objects.min_quanta = 3; }), tile, "objects: expected 2"));
  CHECK(
      finds(verify_objects([](ObjectPack& p) { p.tile.objects[1].model = 7; }), tile, "a model of the pack"));
  CHECK(finds(verify_objects([](ObjectPack& p) { p.tile.objects[1].scale = 400; }), tile, "by its size"));
  CHECK(finds(verify_objects([](ObjectPack& p) { p.objects.geometric_error_m = 59; }), tile,
              "a size of at most"));
  CHECK(finds(verify_objects([](ObjectPack& p) { p.tile.lowest_quanta = 1; }), tile, "lowest foot"));
  CHECK(finds(verify_objects([](ObjectPack& p) { p.tile.highest_quanta = 10; }), tile, "highest foot"));
  CHECK(finds(verify_objects([](ObjectPack& p) { p.objects.id = {2, 8, 5}; }), "objects 2/8/5", "a void"));
}

TEST_CASE("verify finds models that break a rule, each by its own line") {
  CHECK(finds(verify_objects([](ObjectPack& p) { p.model_entries[1].id.x = 2; }), "models 9/2/0", "address"));
  CHECK(finds(verify_objects([](ObjectPack& p) { p.model_entries[0].min_quanta = 9; }), "models 9/0/0",
              "triangles: expected 10"));
  CHECK(finds(verify_objects([](ObjectPack& p) { p.model_entries[0].geometric_error_m = 61; }),
              "models 9/0/0", "size: expected"));
}

}  // namespace cairn
