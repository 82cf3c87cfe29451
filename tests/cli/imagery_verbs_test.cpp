// `cairn bake --imagery` and what is done with its packs, as a person or a script meets them.
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "format/bytes.h"
#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::is_one_line;
using test::Ran;
using test::run_cairn;

// A plain RGB TIFF in one strip (TIFF 6.0, sections 2 and 6), with waves and grain.
std::vector<std::byte> tiff_of(std::uint32_t side) {
  std::vector<std::byte> file;
  ByteWriter out(file);
  constexpr std::uint16_t kEntries = 9;
  constexpr std::uint32_t kAfterEntries = 8 + 2 + 12 * kEntries + 4;
  out.append(std::as_bytes(std::span("II*\0", 4)));
  out.write(std::uint32_t{8});
  out.write(kEntries);
  const auto entry = [&](std::uint16_t tag, std::uint16_t type, std::uint32_t count, std::uint32_t value) {
    out.write(tag);
    out.write(type);
    out.write(count);
    out.write(value);
  };
  entry(256, 4, 1, side);
  entry(257, 4, 1, side);
  entry(258, 3, 3, kAfterEntries);
  entry(259, 3, 1, 1);
  entry(262, 3, 1, 2);
  entry(273, 4, 1, kAfterEntries + 6);
  entry(277, 3, 1, 3);
  entry(278, 4, 1, side);
  entry(279, 4, 1, side * side * 3);
  out.write(std::uint32_t{0});
  for (int i = 0; i < 3; ++i) out.write(std::uint16_t{8});
  std::mt19937 random(7);
  for (std::uint32_t r = 0; r < side; ++r)
    for (std::uint32_t c = 0; c < side; ++c)
      for (std::uint32_t k = 0; k < 3; ++k)
        out.write(static_cast<std::uint8_t>((c * (k + 1) / 8 + r / 4) % 200 + random() % 40));
  return file;
}

struct Ortho {
  explicit Ortho(std::uint32_t side) {
    test::write_bytes(image, tiff_of(side));
    std::ofstream(dir.path() / "ortho.tfw") << "1e-4 0 0 -1e-4 20.00005 44.99995\n";
  }
  std::string in_dir(const std::string& name) const { return (dir.path() / name).string(); }
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(dir.path()), fs::directory_iterator()));
  }

  test::TempDir dir;
  fs::path image = dir.path() / "ortho.tif";
};

}  // namespace

TEST_CASE("imagery alone is baked, described, verified and extracted") {
  const Ortho ortho(700);
  const std::string pack = ortho.in_dir("a.cairn");
  const Ran baked = run_cairn({"bake", "--imagery", ortho.image, "-o", pack, "--tile-size", "257", "--json"});
  INFO(baked.err);
  REQUIRE(baked.exit_code == 0);
  CHECK(json::parse(baked.out).at("texels") > 700 * 700);
  CHECK(json::parse(baked.out).at("samples") == 0);
  const json info = json::parse(run_cairn({"info", pack, "--json"}).out);
  CHECK(info.at("imagery").at("format") == "bc1");
  CHECK(info.at("levels").empty());
  const json& finest = info.at("imagery").at("levels").back();
  CHECK(finest.at("level") == 6);
  CHECK(finest.at("psnr_db") > 25);
  CHECK(run_cairn({"verify", pack}).exit_code == 0);
  const Ran extracted = run_cairn(
      {"extract", pack, "6/12801/8638", "--layer", "imagery", "-o", ortho.in_dir("t.dds"), "--json"});
  INFO(extracted.err);
  REQUIRE(extracted.exit_code == 0);
  CHECK(json::parse(extracted.out).at("samples") == 256);
  CHECK(fs::file_size(ortho.in_dir("t.dds")) > 256 * 256 / 2);
  const Ran heights = run_cairn({"extract", pack, "6/12801/8638", "-o", ortho.in_dir("t.tif")});
  CHECK(heights.exit_code == 1);
  CHECK(is_one_line(heights.err));
}

TEST_CASE(
    "what cannot be baked as imagery is refused in one line, with the right exit code and nothing left") {
  const Ortho ortho(300);
  const std::string pack = ortho.in_dir("a.cairn");
  const std::size_t files_before = ortho.files();
  const auto refused = [&](std::vector<std::string> arguments, int exit_code) {
    arguments.insert(arguments.begin(), {"bake", "-o", pack});
    const Ran ran = run_cairn(arguments);
    INFO(ran.err);
    CHECK(ran.exit_code == exit_code);
    CHECK(ran.out.empty());
    CHECK(is_one_line(ran.err));
    CHECK(ortho.files() == files_before);
  };
  refused({"--imagery", ortho.in_dir("none.tif")}, 3);
  refused({"--imagery", (test::sample_dem() / "jacksboro_fault.tif").string()}, 3);
  refused({"--imagery", ortho.image, "--bounds", "1,2,0,3"}, 2);
  refused({"--imagery", ortho.image, "--region", "60,10,61,11"}, 2);
  auto bytes = test::read_bytes(ortho.image);
  bytes.resize(bytes.size() - 5000);
  test::write_bytes(ortho.image, bytes);
  refused({"--imagery", ortho.image}, 3);
}

TEST_CASE("killed at random moments and resumed, a bake of heights and imagery gives the same bytes") {
  const Ortho ortho(1100);
  const std::string dem = (test::sample_dem() / "jacksboro_fault.tif").string();
  const std::string whole = ortho.in_dir("whole.cairn"), cut = ortho.in_dir("cut.cairn");
  const auto bake = [&](const std::string& target) {
    return std::vector<std::string>{"bake", dem,           "--imagery", ortho.image, "-o",
                                    target, "--tile-size", "257",       "--resume"};
  };
  const auto start = std::chrono::steady_clock::now();
  REQUIRE(run_cairn(bake(whole)).exit_code == 0);
  const auto taken =
      std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - start);
  const auto expected = test::read_bytes(whole);
  std::mt19937 random(5);
  std::uniform_int_distribution<long> delay(1, std::max<long>(2, static_cast<long>(taken.count())));
  int killed = 0;
  for (int round = 0; round < 6; ++round) {
    fs::remove(cut);
    for (int kills = 0; kills < 3; ++kills) {
      if (!test::run_cairn_and_kill(bake(cut), std::chrono::milliseconds(delay(random)))) break;
      ++killed;
      if (fs::exists(cut)) break;  // killed after its last step
    }
    if (!fs::exists(cut)) REQUIRE(run_cairn(bake(cut)).exit_code == 0);
    CHECK(test::read_bytes(cut) == expected);
  }
  CHECK(killed >= 6);
}

}  // namespace cairn
