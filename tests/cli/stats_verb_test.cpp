// cairn stats, which is the program cairn-stats beside cairn.

#include <algorithm>
#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

using nlohmann::json;
using test::is_one_line;
using test::run_cairn;
using test::text_of;

std::size_t lines_of(const std::string& text) {
  return static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
}

}  // namespace

TEST_CASE("cairn stats --exhaustive reports the design's table") {
  const test::TempDir dir;
  const std::string out = (dir.path() / "out.json").string();
  const auto ran = run_cairn({"stats", "--exhaustive", "--walk", "axis", "--json", out});
  REQUIRE(ran.exit_code == 0);
  CHECK(ran.err.empty());
  CHECK(ran.out.find("restricted     52    52   52.00      10") != std::string::npos);
  const json report = json::parse(text_of(out));
  CHECK(report["levels"] == 4);
  CHECK(report["moves"] == 4 * 64 * 64);
  for (const json& pattern : report["patterns"]) {
    if (pattern["name"] != "plus") continue;
    CHECK(pattern["total"]["values"] == json({19, 22, 25, 28, 29, 31, 32, 35, 39}));
    CHECK(pattern["difference"]["max"] == 14);
    CHECK(pattern["published"]["total_max"] == 35);
  }
}

TEST_CASE("cairn stats walks, writes a row a move, and draws") {
  const test::TempDir dir;
  const std::string csv = (dir.path() / "out.csv").string(), svg = (dir.path() / "map.svg").string();
  const std::string walk = (dir.path() / "walk").string();
  std::ofstream(walk) << "1,0\n0,1\n-1,-1\n";
  REQUIRE(run_cairn({"stats", "--walk", walk, "--pattern", "cross", "--csv", csv}).exit_code == 0);
  CHECK(lines_of(text_of(csv)) == 1 + 3);
  REQUIRE(run_cairn({"stats", "--pattern", "restricted", "--draw", "5,6", svg}).exit_code == 0);
  CHECK(text_of(svg).find("52 tiles") != std::string::npos);
}

TEST_CASE("cairn stats --pack loads what the moves need, and --loading times blocks") {
  const test::TempDir dir;
  const auto pack = dir.path() / "a.cairn";
  const std::string csv = (dir.path() / "out.csv").string();
  test::write_test_pack(pack, {257, 2, test::hills, {}},
                        test::with_ancestors({{2, 8, 4}, {2, 9, 4}, {2, 10, 5}}, 0));
  const auto ran =
      run_cairn({"stats", "--pack", pack.string(), "--levels", "3", "--moves", "5", "--csv", csv});
  INFO(ran.err);
  REQUIRE(ran.exit_code == 0);
  CHECK(text_of(csv).find("pattern,move,total,difference,latency_ms,bytes\n") == 0);
  REQUIRE(run_cairn({"stats", "--pack", pack.string(), "--loading", "3", "--csv", csv}).exit_code == 0);
  CHECK(lines_of(text_of(csv)) == 1 + 3);
}

TEST_CASE("cairn stats says in one line what is wrong with its options") {
  const test::TempDir dir;
  const std::string missing = (dir.path() / "none").string();
  const std::vector<std::pair<std::vector<std::string>, int>> cases{
      {{"--pattern", "diamond"}, 2},
      {{"--levels", "1"}, 2},
      {{"--levels", "ten"}, 2},
      {{"--no-such-option"}, 2},
      {{"--exhaustive", "--walk", missing}, 2},
      {{"--walk", missing}, 1},
      {{"--draw", "1,1", missing}, 2},
      {{"--pattern", "cross", "--draw", "one", missing}, 2},
      {{"--loading", "5"}, 2},
      {{"--exhaustive", "--pack", missing}, 2},
      {{"--pack", missing}, 1},
      {{"--json", missing + "/x.json"}, 1}};
  for (const auto& [options, code] : cases) {
    std::vector<std::string> words{"stats"};
    words.insert(words.end(), options.begin(), options.end());
    const auto ran = run_cairn(words);
    INFO(options[0] << ": " << ran.err);
    CHECK(ran.exit_code == code);
    CHECK(is_one_line(ran.err));
  }
}

}  // namespace cairn
