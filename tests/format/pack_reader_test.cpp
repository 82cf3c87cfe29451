#include "cairn/pack_reader.h"

#include <atomic>
#include <cmath>
#include <cstring>
#include <random>
#include <thread>

#include <catch2/catch.hpp>

#include "cairn/pack_sampler.h"
#include "format/file.h"
#include "format/pack_writer.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

const test::TestSurface kHills{257, 2, test::hills, {}};

/// Two tiles with blocks, one of them shared by a third, and a constant one.
fs::path small_pack(const test::TempDir& dir) {
  const fs::path path = dir.path() / "small.cairn";
  Result<PackWriter> writer = PackWriter::create(path, test::test_header());
  REQUIRE(writer.ok());
  const std::vector<std::byte> a(70, std::byte{1}), b(90, std::byte{2});
  IndexEntry constant;
  constant.flags = kConstant;
  constant.id = {1, 5, 5};
  constant.min_quanta = constant.max_quanta = -7;
  REQUIRE(writer->add(constant, {}).ok());
  for (const auto& [id, block] :
       {std::pair(TileId{1, 3, 2}, a), {TileId{0, 1, 1}, b}, {TileId{1, 2, 2}, a}}) {
    IndexEntry entry;
    entry.id = id;
    REQUIRE(writer->add(entry, block).ok());
  }
  REQUIRE(writer->finish("{}").ok());
  return path;
}

/// Counts what is read of a file, and says that reads are slow.
class CountingSource : public ByteSource {
 public:
  explicit CountingSource(File file) : file_(std::move(file)) {}

  const fs::path& name() const override { return file_.path(); }
  Result<std::uint64_t> size() const override { return file_.size(); }
  bool is_slow() const override { return true; }
  using ByteSource::read;
  Status read(std::uint64_t offset, std::span<std::byte> out) const override {
    ++reads;
    bytes += out.size();
    return file_.read(offset, out);
  }

  mutable std::atomic<std::size_t> reads = 0;
  mutable std::atomic<std::size_t> bytes = 0;

 private:
  File file_;
};

/// Tiles of blocks of a few bytes, which are none of a real layer: side² of the level, and their ancestors.
void write_many_tiles(const fs::path& path, std::int32_t side, int level) {
  Result<PackWriter> writer = PackWriter::create(path, test::test_header());
  REQUIRE(writer.ok());
  for (int l = 0; l <= level; ++l) {
    for (std::int32_t i = 0; i < side * side; ++i) {
      const TileId id{l, i % side, i / side};
      if (id.x > (side - 1) >> (level - l) || id.y > (side - 1) >> (level - l)) continue;
      IndexEntry entry;
      entry.id = id;
      entry.geometric_error_m = static_cast<float>(std::ldexp(8.0, -l));
      std::vector<std::byte> block(sizeof id);
      std::memcpy(block.data(), &id, sizeof id);
      REQUIRE(writer->add(entry, block).ok());
    }
  }
  REQUIRE(writer->finish("{}").ok());
}

}  // namespace

TEST_CASE("a pack gives back every tile and its metadata") {
  const test::TempDir dir;
  const auto tiles = test::with_ancestors({{2, 8, 4}, {2, 9, 4}, {2, 11, 7}}, -1);
  test::write_test_pack(dir.path() / "a.cairn", kHills, tiles);
  const auto reader = PackReader::open(dir.path() / "a.cairn");
  REQUIRE(reader.ok());
  CHECK(reader->metadata_json().starts_with(R"({"cairn":"test")"));
  CHECK(reader->header().vertical_datum == VerticalDatum::egm96);
  REQUIRE(reader->entry_count() == tiles.size());
  for (const TileId& id : tiles) {
    const auto entry = reader->find(Layer::heights, id);
    REQUIRE(entry);
    CHECK(entry->id == id);
    const auto tile = reader->read_height_tile(*entry);
    REQUIRE(tile.ok());
    CHECK(tile->samples == kHills.tile(id).samples);
  }
  REQUIRE(reader->levels(Layer::heights));
  CHECK(reader->levels(Layer::heights)->coarsest == -1);
  CHECK(reader->levels(Layer::heights)->finest == 2);
  CHECK_FALSE(reader->levels(Layer::imagery));
}

TEST_CASE("a tile that the pack lacks is not found, and its nearest ancestor is") {
  const test::TempDir dir;
  test::write_test_pack(dir.path() / "a.cairn", kHills, {{0, 1, 1}, {1, 2, 2}});
  const auto reader = PackReader::open(dir.path() / "a.cairn");
  REQUIRE(reader.ok());
  CHECK_FALSE(reader->find(Layer::heights, {1, 3, 2}));
  CHECK_FALSE(reader->find(Layer::heights, {2, 4, 4}));
  CHECK_FALSE(reader->find(Layer::imagery, {1, 2, 2}));
  CHECK(reader->find_nearest(Layer::heights, {1, 3, 2})->id == TileId{0, 1, 1});
  CHECK(reader->find_nearest(Layer::heights, {7, 128 + 3, 128})->id == TileId{1, 2, 2});
  CHECK_FALSE(reader->find_nearest(Layer::heights, {7, 0, 0}));
  CHECK_FALSE(reader->find_nearest(Layer::heights, {-2, 0, 0}));
}

TEST_CASE("find agrees with a scan of the index over random tiles") {
  const test::TempDir dir;
  std::mt19937 random(3);
  const fs::path path = dir.path() / "a.cairn";
  Result<PackWriter> writer = PackWriter::create(path, test::test_header());
  REQUIRE(writer.ok());
  std::vector<TileId> ids;
  for (int i = 0; i < 400; ++i) {
    IndexEntry entry;
    entry.flags = kConstant;
    entry.id = {static_cast<int>(random() % 3), static_cast<std::int32_t>(random() % 30),
                static_cast<std::int32_t>(random() % 30)};
    if (std::find(ids.begin(), ids.end(), entry.id) != ids.end()) continue;
    ids.push_back(entry.id);
    REQUIRE(writer->add(entry, {}).ok());
  }
  REQUIRE(writer->finish("{}").ok());
  const auto reader = PackReader::open(path);
  REQUIRE(reader.ok());
  for (int level = 0; level < 3; ++level) {
    for (std::int32_t x = 0; x < 30; ++x) {
      for (std::int32_t y = 0; y < 30; ++y) {
        const bool there = std::find(ids.begin(), ids.end(), TileId{level, x, y}) != ids.end();
        REQUIRE(reader->find(Layer::heights, {level, x, y}).has_value() == there);
      }
    }
  }
}

TEST_CASE("an empty pack opens and has nothing") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  Result<PackWriter> writer = PackWriter::create(path, test::test_header());
  REQUIRE(writer.ok());
  REQUIRE(writer->finish("").ok());
  const auto reader = PackReader::open(path);
  REQUIRE(reader.ok());
  CHECK(reader->entry_count() == 0);
  CHECK(reader->metadata_json().empty());
  CHECK_FALSE(reader->find_nearest(Layer::heights, {0, 0, 0}));
}

TEST_CASE("every prefix of a small pack, and a byte too many, is refused", "[slow]") {
  const test::TempDir dir;
  const fs::path path = small_pack(dir);
  auto bytes = test::read_bytes(path);
  REQUIRE(PackReader::open(path).ok());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    test::write_bytes(path, {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)});
    const auto reader = PackReader::open(path);
    REQUIRE_FALSE(reader.ok());
    REQUIRE(reader.error().code == ErrorCode::bad_data);
    REQUIRE_THAT(reader.error().message, Catch::StartsWith(path.string() + ": "));
  }
  bytes.push_back(std::byte{0});
  test::write_bytes(path, bytes);
  CHECK_THAT(PackReader::open(path).error().message, Catch::Contains("file size"));
}

TEST_CASE("a pack cut at every 4 KiB is refused") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  test::write_test_pack(path, kHills, test::with_ancestors({{2, 8, 4}}, 0));
  for (std::uint64_t length = (fs::file_size(path) - 1) / 4096 * 4096; length > 0; length -= 4096) {
    fs::resize_file(path, length);
    REQUIRE_FALSE(PackReader::open(path).ok());
  }
}

TEST_CASE("what is no pack, or not there, is refused in one line") {
  const test::TempDir dir;
  const auto missing = PackReader::open(dir.path() / "none.cairn");
  CHECK_THAT(missing.error().message, Catch::Contains("none.cairn: open: No such file"));
  CHECK(PackReader::open(dir.path()).error().code == ErrorCode::bad_data);
  test::write_bytes(dir.path() / "text", std::vector<std::byte>(4096, std::byte{'x'}));
  CHECK_THAT(PackReader::open(dir.path() / "text").error().message, Catch::Contains("magic"));
}

TEST_CASE("a planet's pages are read when something in them is asked for, and no others") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  write_many_tiles(path, 60, 4);  // 60 x 60 tiles of level 4 and their ancestors
  auto file = File::open_to_read(path);
  REQUIRE(file.ok());
  auto counted = std::make_unique<CountingSource>(std::move(*file));
  const CountingSource& source = *counted;
  const auto reader = PackReader::open(std::move(counted));
  REQUIRE(reader.ok());
  CHECK(source.reads == 1);
  CHECK(source.bytes == kPackStartBytes);
  const auto entry = reader->find(Layer::heights, {4, 30, 30});
  REQUIRE(entry);
  CHECK(source.reads == 2);
  REQUIRE(reader->read_block(*entry).ok());
  CHECK(source.bytes <= 64 * 1024);
  const auto before = source.reads.load();
  for (int i = 0; i < 100; ++i) CHECK(reader->find(Layer::heights, {4, 30, 30}));
  CHECK(source.reads == before);
  std::vector<ByteRange> pages;
  REQUIRE(reader->read_index([&](const ByteRange& page) { pages.push_back(page); }).ok());
  CHECK(pages.size() > 2);
  for (const ByteRange& page : pages) CHECK(page.bytes <= 16384);
  CHECK_FALSE(reader->metadata_json().empty());
}

TEST_CASE("a damaged page of the index: what it may hold gives its error, and the rest is there") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  write_many_tiles(path, 60, 4);
  const std::uint64_t index = PackReader::open(path)->header().index_offset;
  auto bytes = test::read_bytes(path);
  bytes[index + 100] ^= std::byte{1};  // of the first leaf, which has the coarse levels
  test::write_bytes(path, bytes);
  const auto reader = PackReader::open(path);
  REQUIRE(reader.ok());
  const auto told = [&](const Result<std::vector<std::byte>>& block) {
    REQUIRE_FALSE(block.ok());
    CHECK(block.error().code == ErrorCode::bad_data);
    CHECK_THAT(block.error().message, Catch::StartsWith(path.string() + ": index page at byte " +
                                                        std::to_string(index) + ": checksum"));
  };
  const auto coarse = reader->find(Layer::heights, {0, 1, 1});
  REQUIRE(coarse);
  CHECK((coarse->flags & kUnreadable) != 0);
  told(reader->read_block(*coarse));
  told(reader->read_block(reader->entry(3)));
  CHECK_FALSE(reader->read_height_tile(*coarse).ok());
  CHECK(reader->find_index(Layer::heights, {0, 1, 1}));
  const auto fine = reader->find(Layer::heights, {4, 59, 59});
  REQUIRE(fine);
  CHECK(reader->read_block(*fine).ok());
  CHECK_FALSE(reader->find(Layer::heights, {4, 60, 59}));
  CHECK_FALSE(reader->read_index().ok());
  PackSampler sampler(*reader);
  CHECK_FALSE(sampler.height_at({-179.99, -89.99}, 0).ok());
}

TEST_CASE("a damaged block is told by its checksum, with the tile named") {
  const test::TempDir dir;
  const fs::path path = small_pack(dir);
  auto bytes = test::read_bytes(path);
  bytes[kPackStartBytes] ^= std::byte{4};
  test::write_bytes(path, bytes);
  const auto reader = PackReader::open(path);
  REQUIRE(reader.ok());
  const auto block = reader->read_block(*reader->find(Layer::heights, {1, 3, 2}));
  REQUIRE_FALSE(block.ok());
  CHECK_THAT(block.error().message, Catch::Contains("heights tile 1/3/2: block: checksum"));
  CHECK(reader->read_block(*reader->find(Layer::heights, {0, 1, 1})).ok());
}

TEST_CASE("a constant tile is expanded without a read") {
  const test::TempDir dir;
  const auto reader = PackReader::open(small_pack(dir));
  REQUIRE(reader.ok());
  const auto tile = reader->read_height_tile(*reader->find(Layer::heights, {1, 5, 5}));
  REQUIRE(tile.ok());
  CHECK(tile->samples == std::vector<std::int32_t>(257 * 257, -7));
  CHECK(tile->voids.empty());
}

TEST_CASE("threads that share a reader get the same tiles") {
  const test::TempDir dir;
  const auto tiles = test::with_ancestors({{2, 8, 4}, {2, 9, 5}, {2, 10, 6}}, 0);
  test::write_test_pack(dir.path() / "a.cairn", kHills, tiles);
  const auto reader = PackReader::open(dir.path() / "a.cairn");
  REQUIRE(reader.ok());
  std::atomic<int> wrong = 0;
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t i = 0; i < tiles.size() * 3; ++i) {
        const TileId id = tiles[(i * 5 + t) % tiles.size()];
        const auto tile = reader->read_height_tile(*reader->find(Layer::heights, id));
        if (!tile || tile->samples != kHills.tile(id).samples) ++wrong;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  CHECK(wrong == 0);
}

TEST_CASE("a pack that is cut short while it is open gives errors, and its index stays") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  const auto tiles = test::with_ancestors({{2, 8, 4}, {2, 9, 5}, {2, 10, 6}}, 0);
  test::write_test_pack(path, kHills, tiles);
  const auto reader = PackReader::open(path);
  REQUIRE(reader.ok());
  const auto size = fs::file_size(path);
  std::size_t unreadable = 0;
  for (const auto left : {size - 1, size / 2, std::uintmax_t{1}, std::uintmax_t{0}}) {
    fs::resize_file(path, left);
    CHECK(reader->entry_count() == tiles.size());
    CHECK(reader->metadata_json().starts_with(R"({"cairn":"test")"));
    std::size_t now_unreadable = 0;
    for (const TileId& id : tiles) {
      const auto entry = reader->find(Layer::heights, id);
      REQUIRE(entry);
      const auto tile = reader->read_height_tile(*entry);
      if (tile) continue;
      ++now_unreadable;
      CHECK(tile.error().code == ErrorCode::bad_data);
      CHECK(tile.error().message.find(path.string()) == 0);
    }
    CHECK(now_unreadable >= unreadable);
    unreadable = now_unreadable;
  }
  CHECK(unreadable == tiles.size());
}

}  // namespace cairn
