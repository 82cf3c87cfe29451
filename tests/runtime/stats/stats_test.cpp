#include <algorithm>
#include <fstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "runtime/stats/block_count.h"
#include "runtime/stats/draw_map.h"
#include "runtime/stats/report.h"
#include "tests/support/test_data.h"

namespace cairn {
namespace {

std::size_t count_of(const std::string& text, std::string_view part) {
  std::size_t count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

Result<std::vector<Move>> walk_from(const std::string& text) {
  const test::TempDir dir;
  const auto path = dir.path() / "walk.csv";
  std::ofstream(path) << text;
  return read_walk(path);
}

}  // namespace

TEST_CASE("a seed gives one walk, of moves of its kind only") {
  const auto kinds = moves_of_kind("diagonal");
  const auto walk = random_walk(kinds, 1000, 3);
  const auto again = random_walk(kinds, 1000, 3);
  const auto other = random_walk(kinds, 1000, 4);
  const auto same = [](const Move& a, const Move& b) { return a.dx == b.dx && a.dy == b.dy; };
  CHECK(std::equal(walk.begin(), walk.end(), again.begin(), same));
  CHECK_FALSE(std::equal(walk.begin(), walk.end(), other.begin(), same));
  for (const Move& move : walk) CHECK(move.dx * move.dx + move.dy * move.dy == 2);
  CHECK(moves_of_kind("sideways").empty());
}

TEST_CASE("a walk is read from lines dx,dy and a bad line is named") {
  const auto walk = walk_from("# two moves\n1,-1\n\n0,12\n");
  REQUIRE(walk.ok());
  REQUIRE(walk->size() == 2);
  CHECK((*walk)[0].dy == -1);
  CHECK((*walk)[1].dy == 12);
  for (const char* bad : {"1", "1;2", "1,", ",1", "1,2,3", "1,2 ", "99999999999,0"}) {
    const auto refused = walk_from(std::string("0,0\n") + bad + "\n");
    REQUIRE_FALSE(refused.ok());
    CHECK(refused.error().code == ErrorCode::bad_data);
    CHECK(refused.error().message.find("line 2: expected dx,dy, found ") != std::string::npos);
  }
}

TEST_CASE("a walk's counts add up: what the map gains less what it loses is how it grows") {
  for (const RefinementPattern pattern : all_refinement_patterns()) {
    const CountSpec spec{endless_world(), 4, pattern, 8, nullptr};
    const auto walk = random_walk(moves_of_kind("random"), 300, 9);
    const auto counts = count_moves(shown_along(spec, walk));
    REQUIRE(counts.size() == walk.size());
    TileId eye = spec.start;
    auto here = counted_tiles(spec, eye);
    for (std::size_t i = 0; i < walk.size(); ++i) {
      eye = neighbour_of(eye, walk[i].dx, walk[i].dy);
      const auto there = counted_tiles(spec, eye);
      REQUIRE(counts[i].total == there.size());
      const std::size_t lost = difference(there, here).size();
      REQUIRE(here.size() + counts[i].difference - lost == there.size());
      here = there;
    }
  }
}

TEST_CASE("a drawing has a rectangle a tile and one black one for the eye") {
  const TileId eye = neighbour_of(endless_world(), 5, 6);
  const SceneMap map = build_scene_map({eye, eye.level - 3});
  const std::string svg = draw_map(map, eye, "restricted");
  CHECK(count_of(svg, "stroke=") == map.size());
  CHECK(count_of(svg, "fill=\"black\"") == 1);
}

TEST_CASE("the report says what was counted and leaves out what was not measured") {
  StatsReport report{4, "axis", 7, false, "", {{RefinementPattern::restricted, {{52, 10}, {52, 8}}, {}}}};
  const auto pattern_of = [](const StatsReport& from) {
    return nlohmann::json::parse(to_json(from)).at("patterns").at(0);
  };
  const auto counted = pattern_of(report);
  CHECK(counted.at("difference").at("histogram") == nlohmann::json{{"8", 1}, {"10", 1}});
  CHECK(counted.at("total").at("max") == 52);
  CHECK_FALSE(counted.contains("latency_ms"));
  CHECK(to_csv(report) == "pattern,move,total,difference\nrestricted,1,52,10\nrestricted,2,52,8\n");

  report.pack = "x.cairn";
  report.patterns[0].loads = {{1.5, 1000}, {2.5, 3000}};
  CHECK(pattern_of(report).at("latency_ms").at("max") == 2.5);
  CHECK(pattern_of(report).at("bytes").at("max") == 3000);
  CHECK(to_csv(report).find("restricted,2,52,8,2.5,3000\n") != std::string::npos);
}

}  // namespace cairn
