// What `cairn bake` takes for its inputs: packed files, links, lists, folders in folders; and a region of
// them.

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"
#include "tests/support/test_data.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::is_one_line;
using test::run_cairn;

std::string jacksboro() {
  return (test::sample_dem() / "jacksboro_fault.tif").string();
}

}  // namespace

TEST_CASE("a link of a folder that leads nowhere is an error that names it, not a hole in the terrain") {
  const test::TempDir dir;
  fs::create_directory(dir.path() / "in");
  fs::copy_file(jacksboro(), dir.path() / "in" / "a.tif");
  fs::create_symlink("/nowhere/b.tif", dir.path() / "in" / "b.tif");
  fs::create_symlink("/nowhere/notes.txt", dir.path() / "in" / "notes.txt");  // no raster by its name
  const std::string out = (dir.path() / "a.cairn").string();
  for (const std::string input : {"in", "in/*.tif", "in/b.tif"}) {
    const auto ran = run_cairn({"bake", (dir.path() / input).string(), "-o", out});
    INFO(ran.err);
    CHECK(ran.exit_code == 3);
    CHECK(is_one_line(ran.err));
    CHECK_THAT(ran.err, Catch::Contains("b.tif") && Catch::Contains("/nowhere/b.tif is not there"));
  }
  fs::remove(dir.path() / "in" / "b.tif");
  CHECK(run_cairn({"bake", (dir.path() / "in").string(), "-o", out}).exit_code == 0);
}

TEST_CASE("inputs come from a list and from folders in folders") {
  const test::TempDir dir;
  fs::create_directories(dir.path() / "in" / "deeper" / ".hidden");
  fs::copy_file(jacksboro(), dir.path() / "in" / "deeper" / "a b.tif");
  fs::copy_file(jacksboro(), dir.path() / "in" / "deeper" / ".hidden" / "c.tif");
  const std::string folder = (dir.path() / "in").string(), out = (dir.path() / "a.cairn").string();
  const auto flat = run_cairn({"bake", folder, "-o", out});
  CHECK(flat.exit_code == 3);
  CHECK_THAT(flat.err, Catch::Contains("expected rasters in the folder"));
  const auto deep = run_cairn({"bake", folder, "--recursive", "-o", out, "--json"});
  INFO(deep.err);
  REQUIRE(deep.exit_code == 0);
  CHECK(json::parse(deep.out)["sources"].size() == 1);

  const fs::path list = dir.path() / "list.txt";
  std::ofstream(list) << "# DEMs\r\n\r\n  " << folder << "/deeper/a b.tif\r\n";
  const auto listed = run_cairn({"bake", "@" + list.string(), "-o", out, "--force", "--json"});
  INFO(listed.err);
  REQUIRE(listed.exit_code == 0);
  CHECK(json::parse(listed.out)["sources"][0]["name"] == "a b.tif");

  std::ofstream(list) << folder << "/deeper/a b.tif\n" << folder << "/none.tif\n";
  const auto wrong = run_cairn({"bake", "@" + list.string(), "-o", out, "--force"});
  CHECK(wrong.exit_code == 3);
  CHECK(is_one_line(wrong.err));
  CHECK_THAT(wrong.err, Catch::Contains("list.txt: line 2: ") && Catch::Contains("none.tif"));
  CHECK(run_cairn({"bake", "@" + (dir.path() / "no.txt").string(), "-o", out}).exit_code == 3);
}

TEST_CASE(
    "the bounds of a pack of a region are the region's, and sources without a post in it are not named") {
  const test::TempDir dir;
  const std::string out = (dir.path() / "a.cairn").string();
  const auto ran = run_cairn(
      {"bake", test::sample_dem().string(), "--region", "-84.3,36.5,-84.2,36.6", "-o", out, "--json"});
  INFO(ran.err);
  REQUIRE(ran.exit_code == 0);
  const json info = json::parse(run_cairn({"info", out, "--json"}).out);
  CHECK(info["bounds"] == json{{"west", -84.3}, {"south", 36.5}, {"east", -84.2}, {"north", 36.6}});
  // A source whose posts have all lost against a finer one is named with their number.
  for (const json& source : info["sources"])
    CHECK(source["posts_used"].get<double>() + source["posts_lost"].get<double>() > 0);
  const auto drawn =
      run_cairn({"hillshade", out, "-o", (dir.path() / "r.png").string(), "--size", "20x20", "--json"});
  REQUIRE(drawn.exit_code == 0);
  CHECK(json::parse(drawn.out)["region"] == info["bounds"]);
}

TEST_CASE("negative fractions without a zero are numbers, in places and in regions") {
  const test::TempDir dir;
  const std::string out = (dir.path() / "a.cairn").string();
  const std::string dem = (test::sample_dem() / "etopo5_thinned.tif").string();
  REQUIRE(run_cairn({"bake", dem, "--region", "-.75,-.5,.5,.75", "-o", out}).exit_code == 0);
  const auto with_zero = run_cairn({"sample", out, "-0.5", "-0.25"});
  REQUIRE(with_zero.exit_code == 0);
  CHECK(with_zero.out.size() > 1);
  const auto without = run_cairn({"sample", out, "-.5", "-.25"});
  CHECK(without.exit_code == 0);
  CHECK(without.out == with_zero.out);
  CHECK(run_cairn({"sample", out, "-.x", "1"}).exit_code == 2);
}

TEST_CASE("a region whose east is not above its west lies across the antimeridian") {
  const test::TempDir dir;
  const std::string out = (dir.path() / "a.cairn").string();
  const std::string dem = (test::sample_dem() / "etopo5_thinned.tif").string();
  const auto ran = run_cairn({"bake", dem, "--region", "179,-1,-179,1", "-o", out});
  INFO(ran.err);
  REQUIRE(ran.exit_code == 0);
  const auto info = run_cairn({"info", out, "--json"});
  REQUIRE(info.exit_code == 0);
  const json bounds = json::parse(info.out)["bounds"];
  INFO(bounds.dump());
  CHECK(bounds["east"].get<double>() - bounds["west"].get<double>() == Approx(2));
  for (const char* lon : {"179.5", "180", "-179.5"})
    CHECK(run_cairn({"sample", out, lon, "0.5"}).out.size() > 1);
  const auto wrong = run_cairn({"bake", dem, "--region", "10,5,20,-5", "-o", out, "--force"});
  CHECK(wrong.exit_code == 2);
  CHECK(is_one_line(wrong.err));
}

TEST_CASE("Ctrl-C ends a bake with what --resume goes on from") {
  const test::TempDir dir;
  const std::string whole = (dir.path() / "whole.cairn").string(), cut = (dir.path() / "cut.cairn").string();
  const auto bake = [&](const std::string& target) {
    return std::vector<std::string>{"bake", jacksboro(),   "-o",  target,      "--level",
                                    "5",    "--tile-size", "257", "--threads", "2"};
  };
  REQUIRE(run_cairn(bake(whole)).exit_code == 0);
  // The signal comes when the journal has grown, so while units are baked; a bake that is over before is
  // tried again.
  for (int tries = 0; tries < 20; ++tries) {
    fs::remove(cut);
    const auto ran = test::run_cairn_and_interrupt(bake(cut), cut + ".journal");
    if (!ran) continue;
    INFO(ran->err);
    CHECK(ran->exit_code == -1);  // by the signal, as whoever started it has to see
    CHECK(is_one_line(ran->err));
    CHECK_THAT(ran->err, Catch::Contains("cancelled") && Catch::Contains("--resume"));
    CHECK_FALSE(fs::exists(cut));
    auto again = bake(cut);
    again.emplace_back("--resume");
    again.emplace_back("--json");
    const auto resumed = run_cairn(again);
    INFO(resumed.err);
    REQUIRE(resumed.exit_code == 0);
    CHECK(json::parse(resumed.out)["resumed"] == true);
    CHECK(test::text_of(cut) == test::text_of(whole));
    return;
  }
  FAIL("no bake was interrupted");
}

}  // namespace cairn
