// The verbs that write files from a pack: extract and hillshade.

#include <array>
#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::is_one_line;
using test::run_cairn;

const test::TestSurface kHills{257, 2, test::hills, {}};

struct PackFile {
  PackFile() {
    test::write_test_pack(path, kHills, test::with_ancestors({{2, 8, 4}, {2, 9, 4}, {2, 10, 5}}, 0));
  }
  std::string in_dir(const std::string& name) const { return (dir.path() / name).string(); }

  test::TempDir dir;
  fs::path path = dir.path() / "a.cairn";
};

std::uint32_t big_endian(const std::vector<std::byte>& bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value = value << 8 | std::to_integer<std::uint32_t>(bytes.at(at + i));
  return value;
}

/// Width, height, bits and colour type from a PNG's header (PNG specification, 11.2.2).
std::array<std::uint32_t, 4> png_header(const fs::path& path) {
  const auto bytes = test::read_bytes(path);
  REQUIRE(bytes.size() > 33);
  REQUIRE(std::to_integer<int>(bytes[1]) == 'P');
  return {big_endian(bytes, 16), big_endian(bytes, 20), std::to_integer<std::uint32_t>(bytes[24]),
          std::to_integer<std::uint32_t>(bytes[25])};
}

/// Files in the folder beside the pack.
std::size_t other_files(const PackFile& pack) {
  std::size_t count = 0;
  for (const auto& entry : fs::directory_iterator(pack.dir.path()))
    count += entry.path() != pack.path ? 1 : 0;
  return count;
}

}  // namespace

TEST_CASE("extract writes a tile in each of its formats and says where it lies") {
  const PackFile pack;
  for (const std::string name : {"t.tif", "t.PNG"}) {
    const auto ran = run_cairn({"extract", pack.path, "2/9/4", "-o", pack.in_dir(name), "--json"});
    INFO(ran.err);
    REQUIRE(ran.exit_code == 0);
    CHECK(json::parse(ran.out).at("bounds").at("west") == -177.75);
    CHECK(fs::file_size(pack.in_dir(name)) > 1000);
  }
  CHECK(png_header(pack.in_dir("t.PNG")) == std::array<std::uint32_t, 4>{257, 257, 16, 0});
  CHECK(other_files(pack) == 2);
}

TEST_CASE("extract refuses a tile that is none, one that the pack lacks and a name of another format") {
  const PackFile pack;
  const auto fails = [&](const std::string& tile, const std::string& output, int exit_code,
                         const char* words) {
    const auto ran = run_cairn({"extract", pack.path, tile, "-o", output});
    CHECK(ran.exit_code == exit_code);
    CHECK(is_one_line(ran.err));
    CHECK_THAT(ran.err, Catch::Contains(words));
  };
  for (const char* tile : {"2/9", "2/9/4/", "a/b/c", "2/99999/4", "-10/0/0", "2/9/720", "99999999999/0/0"}) {
    fails(tile, pack.in_dir("t.tif"), 2, "expected L/X/Y");
  }
  fails("2/9/5", pack.in_dir("t.tif"), 1, "the pack has none");
  fails("2/9/4", pack.in_dir("t.jpg"), 2, "ends in .tif, .png or .hgt");
  for (const char* name : {"no/t.tif", "no/t.png"}) fails("2/9/4", pack.in_dir(name), 1, name);
  fails("2/9/4", pack.in_dir("S89W178.hgt"), 2, "one cell of 1 degree");
  fails("0/2/1", pack.in_dir("relief.hgt"), 2, "S89W178.hgt");
  CHECK(other_files(pack) == 0);
}

TEST_CASE("hillshade draws the size that was asked for, from the level that fits it") {
  const PackFile pack;
  const auto level_of = [&](const std::string& size) -> int {
    const auto ran =
        run_cairn({"hillshade", pack.path, "-o", pack.in_dir("r.png"), "--size", size, "--json"});
    INFO(ran.err);
    REQUIRE(ran.exit_code == 0);
    return json::parse(ran.out).at("level");
  };
  CHECK(level_of("60x40") == 0);
  CHECK(png_header(pack.in_dir("r.png")) == std::array<std::uint32_t, 4>{60, 40, 8, 6});
  CHECK(level_of("256x200") == 1);
  CHECK(level_of("512x512") == 2);
  CHECK(other_files(pack) == 2);  // and its world file
}

TEST_CASE("hillshade without a size is true to the ground, and takes a region across the antimeridian") {
  const PackFile pack;
  REQUIRE(run_cairn({"hillshade", pack.path, "-o", pack.in_dir("r.png"), "--region", "-178,-60,-177,-59"})
              .exit_code == 0);
  const auto header = png_header(pack.in_dir("r.png"));
  CHECK(header[1] == 1024);
  CHECK(header[0] == Approx(1024 * 0.5075).margin(1));  // the cosine of 59.5 degrees
  const auto across = run_cairn({"hillshade", pack.path, "-o", pack.in_dir("r.png"), "--region",
                                 "179,-90,-177,-88", "--size", "40x20", "--json"});
  REQUIRE(across.exit_code == 0);
  CHECK(json::parse(across.out).at("region").at("east") == 183);
}

TEST_CASE("hillshade refuses sizes and regions that are none, and leaves no file behind") {
  const PackFile pack;
  const auto fails = [&](const std::string& option, const std::string& value) {
    const auto ran = run_cairn({"hillshade", pack.path, "-o", pack.in_dir("r.png"), option, value});
    INFO(option << " " << value);
    CHECK(ran.exit_code == 2);
    CHECK(is_one_line(ran.err));
  };
  for (const char* size : {"0x5", "5", "5x", "x5", "5x5x5", "-5x5", "99999x5", "axb"}) fails("--size", size);
  for (const char* region : {"1,2,3", "1,2,3,x", "0,10,5,5", "0,-91,5,5", "0,0,900,5", "nan,0,1,1"}) {
    fails("--region", region);
  }
  const auto unwritable = run_cairn({"hillshade", pack.path, "-o", pack.in_dir("no/r.png"), "--size", "8x8"});
  CHECK(unwritable.exit_code == 1);
  CHECK(is_one_line(unwritable.err));
  auto bytes = test::read_bytes(pack.path);
  bytes[kPackStartBytes + 30] ^= std::byte{1};
  test::write_bytes(pack.path, bytes);
  CHECK(run_cairn({"hillshade", pack.path, "-o", pack.in_dir("r.png"), "--size", "512x512"}).exit_code == 3);
  CHECK(other_files(pack) == 0);
}

}  // namespace cairn
