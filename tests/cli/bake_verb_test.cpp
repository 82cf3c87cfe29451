// `cairn bake` as a person or a script meets it: what it prints, what it refuses, and what it leaves behind.

#include <chrono>
#include <filesystem>
#include <random>
#include <thread>

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
using test::Ran;
using test::run_cairn;

std::string jacksboro() {
  return (test::sample_dem() / "jacksboro_fault.tif").string();
}

std::size_t files_in(const fs::path& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

// Refused with one line on stderr, nothing on stdout, and nothing left in the folder.
void expect_refusal(const std::vector<std::string>& arguments, int exit_code, const fs::path& folder,
                    std::size_t files_before) {
  const Ran ran = run_cairn(arguments);
  std::string line;
  for (const auto& a : arguments) line += a + " ";
  INFO(line << "\n" << ran.err);
  CHECK(ran.exit_code == exit_code);
  CHECK(ran.out.empty());
  CHECK(is_one_line(ran.err));
  CHECK(files_in(folder) == files_before);
}

}  // namespace

TEST_CASE("bake prints a report, and --report and --json give the promised keys") {
  const test::TempDir dir;
  const std::string pack = (dir.path() / "a.cairn").string();
  const std::string report = (dir.path() / "r.json").string();
  const Ran ran = run_cairn({"bake", jacksboro(), "-o", pack, "--report", report, "--json"});
  INFO(ran.err);
  REQUIRE(ran.exit_code == 0);
  for (const json& r :
       {json::parse(ran.out),
        json::parse(std::string(reinterpret_cast<const char*>(test::read_bytes(report).data()),
                                test::read_bytes(report).size()))}) {
    for (const char* key : {"format_version", "tile_size", "quantum_m", "vertical_datum", "bounds",
                            "file_bytes", "levels", "accuracy", "sources", "seconds", "samples",
                            "samples_per_second", "peak_rss_mib", "threads", "options"}) {
      INFO(key);
      CHECK(r.contains(key));
    }
    CHECK(r["accuracy"]["posts"] == 344 * 403);
    CHECK(r["accuracy"]["max_m"].get<double>() <= 0.5);
    CHECK(r["file_bytes"].get<std::uint64_t>() == fs::file_size(pack));
    CHECK(r["sources"][0]["posts_used"] == 344 * 403);
  }
  const Ran verified = run_cairn({"verify", pack, "--against", jacksboro(), "--json"});
  CHECK(verified.exit_code == 0);
  CHECK(json::parse(verified.out)["ok"] == true);
  const Ran wrong = run_cairn(
      {"verify", pack, "--against", (test::sample_dem() / "etopo5_thinned.tif").string(), "--json"});
  CHECK(wrong.exit_code == 3);
}

TEST_CASE("the sample folder bakes: a fault in Tennessee in the whole Earth, five levels apart") {
  const test::TempDir dir;
  const std::string pack = (dir.path() / "a.cairn").string();
  const Ran ran = run_cairn({"bake", test::sample_dem().string(), "-o", pack});
  INFO(ran.err);
  REQUIRE(ran.exit_code == 0);
  const Ran verified = run_cairn({"verify", pack, "--against", test::sample_dem().string()});
  INFO(verified.out);
  CHECK(verified.exit_code == 0);
}

TEST_CASE("a dry run says what would be done and writes nothing") {
  const test::TempDir dir;
  const Ran ran =
      run_cairn({"bake", jacksboro(), "-o", (dir.path() / "a.cairn").string(), "--dry-run", "--json"});
  REQUIRE(ran.exit_code == 0);
  const json plan = json::parse(ran.out);
  CHECK(plan["finest"] == 2);
  CHECK(plan["estimated_bytes"].get<double>() > 0);
  CHECK(files_in(dir.path()) == 0);
}

TEST_CASE("a file whose name is no UTF-8 is baked, and named in valid JSON") {
  const test::TempDir dir;
  const fs::path source = dir.path() / "h\xff\xc3.tif";
  fs::copy_file(jacksboro(), source);
  const std::string pack = (dir.path() / "a.cairn").string();
  const Ran ran = run_cairn({"bake", source.string(), "-o", pack, "--json"});
  INFO(ran.err);
  REQUIRE(ran.exit_code == 0);
  CHECK(json::parse(ran.out)["sources"][0]["posts_used"] == 344 * 403);
  CHECK(json::parse(run_cairn({"info", pack, "--json"}).out)["sources"].size() == 1);
  CHECK(run_cairn({"verify", pack}).exit_code == 0);
}

TEST_CASE("an output that exists is refused without --force and replaced with it") {
  const test::TempDir dir;
  const fs::path pack = dir.path() / "a.cairn";
  test::write_bytes(pack, std::vector<std::byte>(3));
  expect_refusal({"bake", jacksboro(), "-o", pack.string()}, 2, dir.path(), 1);
  CHECK(fs::file_size(pack) == 3);
  CHECK_THAT(run_cairn({"bake", jacksboro(), "-o", pack.string()}).err,
             Catch::Contains("; --force replaces it\n"));
  CHECK(run_cairn({"bake", jacksboro(), "-o", pack.string(), "--force"}).exit_code == 0);
  CHECK(run_cairn({"info", pack.string()}).exit_code == 0);
}

TEST_CASE("options out of range and inputs that are none are refused in one line, with the right exit code") {
  const test::TempDir dir;
  const std::string out = (dir.path() / "a.cairn").string();
  for (const auto& wrong : std::vector<std::vector<std::string>>{{"--tile-size", "512"},
                                                                 {"--level", "99"},
                                                                 {"--level", "two"},
                                                                 {"--top", "3"},
                                                                 {"--max-error", "-1"},
                                                                 {"--quantum", "0"},
                                                                 {"--memory", "3"},
                                                                 {"--threads", "-1"},
                                                                 {"--region", "10,0,5,1"},
                                                                 {"--region", "1,2,3"},
                                                                 {"--region", "10,10,11,11"},
                                                                 {"--void", "dig"},
                                                                 {"--datum", "sea"},
                                                                 {"--geoid", "/nowhere.tif"},
                                                                 {"--frobnicate"}}) {
    std::vector<std::string> arguments{"bake", jacksboro(), "-o", out};
    arguments.insert(arguments.end(), wrong.begin(), wrong.end());
    expect_refusal(arguments, 2, dir.path(), 0);
  }
  expect_refusal({"bake", jacksboro()}, 2, dir.path(), 0);
  expect_refusal({"bake", "-o", out}, 2, dir.path(), 0);
  expect_refusal({"bake", "/nowhere/*.hgt", "-o", out}, 3, dir.path(), 0);
  expect_refusal({"bake", jacksboro(), "-o", "/proc/no/a.cairn"}, 1, dir.path(), 0);
}

TEST_CASE("damaged and lying inputs are refused with nothing left behind") {
  const test::TempDir dir;
  const std::string out = (dir.path() / "a.cairn").string();
  const auto bytes = test::read_bytes(jacksboro());
  const auto try_bytes = [&](const char* name, std::vector<std::byte> content) {
    test::write_bytes(dir.path() / name, content);
    INFO(name);
    const Ran ran = run_cairn({"bake", (dir.path() / name).string(), "-o", out});
    CHECK(ran.exit_code == 3);
    CHECK(is_one_line(ran.err));
    CHECK_THAT(ran.err, Catch::Contains(name));
    CHECK(files_in(dir.path()) == 1);
    fs::remove(dir.path() / name);
  };
  try_bytes("cut.tif", {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(bytes.size() / 2)});
  try_bytes("empty.tif", {});
  try_bytes("N36W085.hgt", std::vector<std::byte>(1201 * 1201 * 2 - 2));
  try_bytes("somewhere.hgt", std::vector<std::byte>(1201 * 1201 * 2));
  try_bytes("garbage.dt1", std::vector<std::byte>(100000, std::byte{0x55}));
}

TEST_CASE("a disk that is full before a unit is done fails the bake in one line and leaves nothing") {
  const test::TempDir dir;
  const std::string out = (dir.path() / "a.cairn").string();
  const Ran ran = test::run_cairn_on_full_disk({"bake", jacksboro(), "-o", out}, 64 * 1024);
  CHECK(ran.exit_code == 1);
  CHECK(is_one_line(ran.err));
  CHECK(files_in(dir.path()) == 0);
}

TEST_CASE("killed at ten random moments and resumed, a bake gives the same bytes") {
  const test::TempDir dir;
  const std::string whole = (dir.path() / "whole.cairn").string();
  const std::string cut = (dir.path() / "cut.cairn").string();
  const auto bake = [&](const std::string& target) {
    return std::vector<std::string>{"bake", jacksboro(),   "-o",  target,    "--level",
                                    "5",    "--tile-size", "257", "--resume"};
  };
  const auto start = std::chrono::steady_clock::now();
  REQUIRE(run_cairn(bake(whole)).exit_code == 0);
  const auto taken =
      std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now() - start);
  const auto expected = test::read_bytes(whole);
  std::mt19937 random(11);
  int killed = 0;
  for (int round = 0; round < 10; ++round) {
    fs::remove(cut);
    std::uniform_int_distribution<long> delay(1, std::max<long>(2, static_cast<long>(taken.count())));
    for (int kills = 0; kills < 3; ++kills) {
      if (!test::run_cairn_and_kill(bake(cut), std::chrono::milliseconds(delay(random)))) break;
      ++killed;
      if (fs::exists(cut)) break;  // killed after its last step
    }
    if (!fs::exists(cut)) {
      const Ran resumed = run_cairn(bake(cut));
      INFO(resumed.err);
      REQUIRE(resumed.exit_code == 0);
    }
    CHECK(test::read_bytes(cut) == expected);
  }
  CHECK(killed >= 10);
}

}  // namespace cairn
