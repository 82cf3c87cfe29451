// scripts/read_pack.py is written from docs/pack-format.md and docs/height-codec.md alone: where it reads a
// pack as the library does, the pages are enough.

#include <sstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "cairn/pack_reader.h"
#include "format/height_block.h"
#include "format/pack_writer.h"
#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

test::Ran read_pack(const std::vector<std::string>& arguments) {
  std::vector<std::string> all{(test::sample_dem().parent_path() / "scripts" / "read_pack.py").string()};
  all.insert(all.end(), arguments.begin(), arguments.end());
  return test::run_python(all);
}

std::string line_of(const IndexEntry& e) {
  std::ostringstream error;
  error.precision(9);
  error << e.geometric_error_m;
  return std::string(to_string(e.layer)) + "/" + to_string(e.id) + " flags " + std::to_string(e.flags) +
         " min " + std::to_string(e.min_quanta) + " max " + std::to_string(e.max_quanta) + " error " +
         error.str() + " filled " + std::to_string(e.filled) + " bytes " + std::to_string(e.bytes) + "\n";
}

std::string listing_of(const PackReader& pack) {
  std::string text;
  for (std::size_t i = 0; i < pack.entry_count(); ++i) text += line_of(pack.entry(i));
  return text;
}

std::string samples_of(const HeightTile& tile) {
  std::string text;
  for (int row = 0; row < tile.size; ++row) {
    for (int column = 0; column < tile.size; ++column) {
      if (column > 0) text += ' ';
      text += tile.is_void(column, row) ? "void" : std::to_string(tile.at(column, row));
    }
    text += '\n';
  }
  return text;
}

void compare_tile(const fs::path& path, const PackReader& pack, const IndexEntry& entry) {
  INFO(path << " " << to_string(entry.id));
  const auto tile = pack.read_height_tile(entry);
  REQUIRE(tile.ok());
  const auto read = read_pack({path.string(), to_string(entry.id)});
  REQUIRE(read.exit_code == 0);
  CHECK((read.out == samples_of(*tile)));  // no megabyte of text where they differ
}

}  // namespace

TEST_CASE(
    "a reader written from the pages gives the tiles of a made pack: both codecs, steps, voids, constants") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  const test::TestSurface hills{257, 2, test::hills, {}};
  const test::TestSurface holes{257, 2, test::hills,
                                [](auto c, auto r) { return (c * c + r * r) % 97 < 30; }};
  auto writer = PackWriter::create(path, test::test_header());
  REQUIRE(writer.ok());
  std::int32_t x = 0;
  for (const HeightCodec* codec : height_codecs()) {
    for (const auto& surface : {hills, holes}) {
      for (const std::int32_t step : {1, 7}) {
        const TileId id{2, 2 * ++x, 4};
        HeightTile tile = surface.tile({2, 8 + x, 4});
        for (std::int32_t& sample : tile.samples) sample *= step;
        REQUIRE(writer->add(test::describe(id, tile), encode_height_block(tile, *codec)).ok());
      }
    }
  }
  HeightTile rock{257, std::vector<std::int32_t>(257 * 257, 0), {}};
  rock.samples[9] = 1 << 30;  // beyond 16 bits
  REQUIRE(
      writer->add(test::describe({2, 0, 9}, rock), encode_height_block(rock, default_height_codec())).ok());
  for (std::int32_t i = 0; i < 3000; ++i) {
    IndexEntry entry;
    entry.flags = kConstant;
    entry.layer = i % 3 == 0 ? Layer::imagery : Layer::heights;
    entry.id = {5, i % 70, i / 70};
    entry.min_quanta = entry.max_quanta = i - 1500;
    REQUIRE(writer->add(entry, {}).ok());
  }
  REQUIRE(writer->finish("{}").ok());
  const auto pack = PackReader::open(path);
  REQUIRE(pack.ok());
  const auto listing = read_pack({path.string()});
  REQUIRE(listing.exit_code == 0);
  CHECK((listing.out == listing_of(*pack)));
  for (std::int32_t i = 1; i <= x; ++i) compare_tile(path, *pack, *pack->find(Layer::heights, {2, 2 * i, 4}));
  compare_tile(path, *pack, *pack->find(Layer::heights, {2, 0, 9}));
  compare_tile(path, *pack, *pack->find(Layer::heights, {5, 1, 0}));
}

TEST_CASE("a reader written from the pages gives the tiles of a baked pack") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  REQUIRE(
      test::run_cairn({"bake", (test::sample_dem() / "jacksboro_fault.tif").string(), "-o", path.string()})
          .exit_code == 0);
  const auto pack = PackReader::open(path);
  REQUIRE(pack.ok());
  const auto listing = read_pack({path.string()});
  REQUIRE(listing.exit_code == 0);
  CHECK((listing.out == listing_of(*pack)));
  const auto finest = pack->levels(Layer::heights)->finest;
  int compared = 0;
  for (std::size_t i = 0; i < pack->entry_count() && compared < 2; ++i) {
    const IndexEntry entry = pack->entry(i);
    if (entry.layer != Layer::heights || entry.bytes == 0 || entry.id.level < finest) continue;
    compare_tile(path, *pack, entry);
    ++compared;
  }
  CHECK(compared == 2);
}

TEST_CASE("a reader written from the pages tells damage in one line") {
  const test::TempDir dir;
  const fs::path path = dir.path() / "a.cairn";
  test::write_test_pack(path, {257, 2, test::hills, {}}, {{2, 8, 4}});
  auto bytes = test::read_bytes(path);
  for (const std::size_t length : {std::size_t{0}, std::size_t{100}, std::size_t{16384}, bytes.size() - 1}) {
    test::write_bytes(dir.path() / "cut.cairn",
                      {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)});
    const auto run = read_pack({"--check", (dir.path() / "cut.cairn").string()});
    CHECK(run.exit_code != 0);
    CHECK(test::is_one_line(run.err));
  }
}

}  // namespace cairn
