// `cairn extract --region` and .hgt cells: one file without holes, with the heights that `sample` gives.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "cairn/pack_reader.h"
#include "cairn/pack_sampler.h"
#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::run_cairn;

const test::TestSurface kHills{257, 2, test::hills, {}};

/// Cell S89W178 with two tiles of level 2 only: all others were left out.
struct PackFile {
  PackFile() { test::write_test_pack(path, kHills, test::with_ancestors({{2, 8, 4}, {2, 10, 5}}, 0)); }
  std::string in_dir(const std::string& name) const { return (dir.path() / name).string(); }

  test::TempDir dir;
  fs::path path = dir.path() / "a.cairn";
};

int big_endian_at(const std::vector<std::byte>& bytes, std::size_t post) {
  return static_cast<std::int16_t>(std::to_integer<int>(bytes.at(2 * post)) << 8 |
                                   std::to_integer<int>(bytes.at(2 * post + 1)));
}

}  // namespace

TEST_CASE("a cell written as .hgt has 1201 posts a side, at each the height that the pack gives there") {
  const PackFile pack;
  const std::string file = pack.in_dir("S89W178.hgt");
  for (const std::vector<std::string>& what :
       {std::vector<std::string>{"0/2/1"}, {"--region", "-178,-89,-177,-88"}}) {
    std::vector<std::string> arguments{"extract", pack.path.string(), "-o", file, "--json"};
    arguments.insert(arguments.end(), what.begin(), what.end());
    const auto ran = run_cairn(arguments);
    INFO(ran.err);
    REQUIRE(ran.exit_code == 0);
    CHECK(json::parse(ran.out)["columns"] == 1201);
    const auto bytes = test::read_bytes(file);
    REQUIRE(bytes.size() == 2 * 1201 * 1201);
    const auto reader = PackReader::open(pack.path);
    REQUIRE(reader.ok());
    PackSampler sampler(*reader);
    int wrong = 0;
    for (int row = 0; row <= 1200; row += 40) {
      for (int column = 0; column <= 1200; column += 40) {
        const auto height = sampler.height_at({-178 + column / 1200.0, -88 - row / 1200.0});
        REQUIRE((height.ok() && height->has_value()));
        const int found =
            big_endian_at(bytes, static_cast<std::size_t>(row) * 1201 + static_cast<std::size_t>(column));
        if (std::abs(found - (*height)->metres) > 0.5 + 1e-3) ++wrong;
      }
    }
    CHECK(wrong == 0);
  }
}

TEST_CASE("a region at a level has the stored samples, and tiles that were left out come from coarser ones") {
  const PackFile pack;
  const auto extract = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"extract", pack.path.string(), "-o", pack.in_dir("r.png"), "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_cairn(arguments);
  };
  const auto fine = extract({"--region", "-178,-89,-177,-88"});
  INFO(fine.err);
  REQUIRE(fine.exit_code == 0);
  const json report = json::parse(fine.out);
  CHECK(report["level"] == 2);
  CHECK(report["columns"] == 1025);
  CHECK(report["rows"] == 1025);
  CHECK(report["bounds"]["west"] == -178);
  CHECK(json::parse(extract({"--region", "-178,-89,-177,-88", "--level", "1"}).out)["columns"] == 513);
  // Samples of level 0 are 1/256 of a degree apart: two of them lie from -177.995 to -177.985.
  const json few = json::parse(extract({"--region", "-177.995,-88.5,-177.985,-88.4", "--level", "0"}).out);
  CHECK(few["columns"] == 2);
  CHECK(few["bounds"]["west"] == -178 + 2 / 256.0);
  const json spaced = json::parse(extract({"--region", "-178,-89,-177,-88.5", "--spacing", "0.1"}).out);
  CHECK(spaced["columns"] == 11);
  CHECK(spaced["rows"] == 6);
}

TEST_CASE("extract refuses what is no region in one line") {
  const PackFile pack;
  const auto fails = [&](const std::vector<std::string>& more, const std::string& name, int exit_code) {
    std::vector<std::string> arguments{"extract", pack.path.string(), "-o", pack.in_dir(name)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const auto ran = run_cairn(arguments);
    INFO(ran.err);
    CHECK(ran.exit_code == exit_code);
    CHECK(test::is_one_line(ran.err));
    CHECK_FALSE(fs::exists(pack.in_dir(name)));
  };
  fails({}, "r.tif", 2);
  fails({"0/2/1", "--region", "-178,-89,-177,-88"}, "r.tif", 2);
  fails({"0/2/1", "--level", "1"}, "r.tif", 2);
  fails({"--region", "-178,-89,-177,-88", "--level", "1", "--spacing", "1"}, "r.tif", 2);
  fails({"--region", "-178,-89,-177,-88", "--spacing", "-1"}, "r.tif", 2);
  fails({"--region", "-178,-88,-177,-89"}, "r.tif", 2);
  fails({"--region", "10,10,11,11"}, "r.tif", 1);
  fails({"--region", "-178,-89,-177,-88", "--layer", "imagery"}, "r.png", 2);
  fails({"--region", "-177.9,-89,-177,-88"}, "S89W178.hgt", 2);
  fails({"--region", "-178,-89,-177,-88"}, "N00E000.hgt", 2);
  fails({"--region", "-178,-89,-177,-88", "--level", "1"}, "S89W178.hgt", 2);
}

TEST_CASE("hillshade writes the format that the name says, georeferenced") {
  const PackFile pack;
  const auto draw = [&](const std::string& name, const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments{"hillshade", pack.path.string(),  "-o",     pack.in_dir(name),
                                       "--region",  "-178,-89,-177,-88", "--size", "40x20"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_cairn(arguments).exit_code;
  };
  REQUIRE(draw("r.tif") == 0);
  REQUIRE(draw("r.png") == 0);
  REQUIRE(draw("r.JPG") == 0);
  CHECK(test::text_of(pack.in_dir("r.tif")).substr(0, 2) == "II");
  CHECK(test::text_of(pack.in_dir("r.JPG")).substr(0, 3) == "\xFF\xD8\xFF");
  for (const char* world : {"r.pgw", "r.jgw"})
    CHECK(test::text_of(pack.in_dir(world)) == "0.025\n0\n0\n-0.05\n-177.9875\n-88.025\n");
  const auto plain = test::text_of(pack.in_dir("r.png"));
  for (const std::vector<std::string>& light :
       {std::vector<std::string>{"--azimuth", "135"}, {"--altitude", "20"}, {"--z", "5"}, {"--grey"}}) {
    REQUIRE(draw("l.png", light) == 0);
    CHECK(test::text_of(pack.in_dir("l.png")) != plain);
  }
  CHECK(draw("r.bmp") == 2);
  CHECK(draw("r") == 2);
  CHECK(draw("l.png", {"--altitude", "0"}) == 2);
  CHECK(draw("l.png", {"--z", "0"}) == 2);
  CHECK(draw("l.png", {"--azimuth", "north"}) == 2);
}

}  // namespace cairn
