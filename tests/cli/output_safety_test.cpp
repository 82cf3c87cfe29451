// No verb writes over a file that it reads, or over one that it did not make; and what is baked survives a
// failure.

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using test::is_one_line;
using test::Ran;
using test::run_cairn;

/// A folder with a DEM of its own, whose bytes must not change.
struct Workplace {
  test::TempDir dir;
  fs::path dem = dir.path() / "dem.tif";
  std::vector<std::byte> bytes;

  Workplace() {
    fs::copy_file(test::sample_dem() / "jacksboro_fault.tif", dem);
    bytes = test::read_bytes(dem);
  }
  std::string at(const std::string& name) const { return (dir.path() / name).string(); }
  std::size_t files() const {
    return static_cast<std::size_t>(
        std::distance(fs::directory_iterator(dir.path()), fs::directory_iterator()));
  }

  /// Wrong usage in one line, and nothing in the folder has changed.
  Ran expect_refusal(const std::vector<std::string>& arguments) const {
    const std::size_t before = files();
    const Ran ran = run_cairn(arguments);
    std::string line;
    for (const auto& a : arguments) line += a + " ";
    INFO(line << "\n" << ran.err);
    CHECK(ran.exit_code == 2);
    CHECK(ran.out.empty());
    CHECK(is_one_line(ran.err));
    CHECK(files() == before);
    CHECK(test::read_bytes(dem) == bytes);
    return ran;
  }
};

std::vector<std::string> small_units(const std::string& dem, const std::string& target) {
  return {"bake", dem, "-o", target, "--level", "5", "--tile-size", "257", "--threads", "2"};
}

std::vector<std::string> with(std::vector<std::string> arguments, std::initializer_list<std::string> more) {
  arguments.insert(arguments.end(), more);
  return arguments;
}

}  // namespace

TEST_CASE("a bake never writes over an input, by whatever name its target leads there") {
  const Workplace place;
  const std::string dem = place.dem.string();
  fs::create_symlink("dem.tif", place.at("symbolic.cairn"));
  fs::create_hard_link(place.dem, place.at("hard.cairn"));
  fs::create_directory(place.at("folder"));
  const std::string by_detour = place.at("folder/../dem.tif");
  const std::string relative = fs::proximate(place.dem).string();
  for (const std::string& target :
       {dem, by_detour, relative, place.at("symbolic.cairn"), place.at("hard.cairn")}) {
    for (const char* more : {"--force", "--resume", "--dry-run"}) {
      const Ran ran = place.expect_refusal({"bake", dem, "-o", target, more});
      CHECK_THAT(ran.err, Catch::Contains("expected an output that is no input"));
    }
    place.expect_refusal({"bake", dem, "-o", target});
  }
  place.expect_refusal({"bake", place.at("*.tif"), "-o", dem, "--force"});
  place.expect_refusal({"bake", place.at("hard.cairn"), "-o", dem, "--force"});
  place.expect_refusal({"bake", "--imagery", dem, "-o", dem, "--force"});
  const std::string other = (test::sample_dem() / "etopo5_thinned.tif").string();
  place.expect_refusal({"bake", other, "-o", dem, "--geoid", dem, "--force"});
}

TEST_CASE("a bake's own unfinished files never take the place of an input or of another program's file") {
  const Workplace place;
  for (const char* suffix : {".part", ".journal"}) {
    for (const bool linked : {true, false}) {
      const std::string target = place.at(std::string(linked ? "l" : "c") + ".cairn");
      if (linked) {
        fs::create_hard_link(place.dem, target + suffix);
      } else {
        fs::copy_file(place.dem, target + suffix);
      }
      for (const char* more : {"--force", "--resume"})
        place.expect_refusal({"bake", place.dem.string(), "-o", target, more});
      CHECK(test::read_bytes(target + suffix) == place.bytes);
      fs::remove(target + suffix);
    }
  }
  fs::create_directory(place.at("d.cairn"));
  fs::create_directory(place.at("e.cairn.part"));
  for (const char* target : {"d.cairn", "e.cairn"})
    place.expect_refusal({"bake", place.dem.string(), "-o", place.at(target), "--force"});
}

TEST_CASE("bake --force replaces packs, and nothing else") {
  const Workplace place;
  const std::string dem = place.dem.string();
  std::ofstream(place.at("thesis.doc")) << "years of work";
  place.expect_refusal({"bake", dem, "-o", place.at("thesis.doc"), "--force"});
  CHECK(test::text_of(place.at("thesis.doc")) == "years of work");
  std::ofstream(place.at("empty"));
  REQUIRE(run_cairn({"bake", dem, "-o", place.at("empty"), "--force"}).exit_code == 0);
  CHECK(run_cairn({"bake", dem, "-o", place.at("empty"), "--force"}).exit_code == 0);
}

TEST_CASE("a report takes the place of a report only") {
  const Workplace place;
  const std::string dem = place.dem.string(), pack = place.at("a.cairn");
  std::ofstream(place.at("notes.txt")) << "mine";
  for (const std::string& report : {dem, pack, pack + ".part", pack + ".journal", place.at("./a.cairn"),
                                    place.at("notes.txt"), place.dir.path().string()})
    place.expect_refusal({"bake", dem, "-o", pack, "--report", report, "--force"});
  CHECK(run_cairn({"bake", dem, "-o", pack, "--report", place.at("no/r.json")}).exit_code == 1);
  CHECK_FALSE(fs::exists(pack));
  for (int twice = 0; twice < 2; ++twice)
    REQUIRE(run_cairn({"bake", dem, "-o", pack, "--force", "--report", place.at("r.json")}).exit_code == 0);
  CHECK(nlohmann::json::parse(test::text_of(place.at("r.json")))["accuracy"]["posts"] == 344 * 403);
}

TEST_CASE("extract and hillshade never write over the pack or over what it was baked from") {
  const Workplace place;
  const std::string pack = place.at("a.png"), dem_named_png = place.at("dem.png");
  REQUIRE(run_cairn({"bake", place.dem.string(), "-o", pack}).exit_code == 0);
  const auto pack_bytes = test::read_bytes(pack);
  fs::copy_file(place.dem, dem_named_png);
  fs::create_symlink("a.png", place.at("link.png"));
  std::ofstream(place.at("started.png.part")) << "a download";
  for (const std::string& output :
       {pack, place.at("link.png"), dem_named_png, place.dem.string(), place.at("started.png")}) {
    place.expect_refusal({"extract", pack, "0/95/126", "-o", output});
    if (output.ends_with(".png")) place.expect_refusal({"hillshade", pack, "-o", output});
  }
  CHECK(test::read_bytes(pack) == pack_bytes);
  CHECK(test::read_bytes(dem_named_png) == place.bytes);
  CHECK(test::text_of(place.at("started.png.part")) == "a download");
  for (int twice = 0; twice < 2; ++twice)
    CHECK(run_cairn({"extract", pack, "0/95/126", "-o", place.at("tile.tif")}).exit_code == 0);
}

TEST_CASE("a full disk keeps what is baked, which is neither lost nor mixed with another bake") {
  const Workplace place;
  const std::string whole = place.at("whole.cairn"), cut = place.at("cut.cairn");
  const auto bake = small_units(place.dem.string(), cut);
  REQUIRE(run_cairn(small_units(place.dem.string(), whole)).exit_code == 0);
  const Ran full = test::run_cairn_on_full_disk(bake, fs::file_size(whole) / 2);
  INFO(full.err);
  CHECK(full.exit_code == 1);
  CHECK(is_one_line(full.err));
  CHECK_THAT(full.err, Catch::Contains("--resume goes on from there"));
  CHECK_FALSE(fs::exists(cut));
  const auto part = test::read_bytes(cut + ".part");
  REQUIRE(part.size() > 1000);

  // The same again would throw it away, and with other options it is another bake's.
  CHECK_THAT(place.expect_refusal(bake).err, Catch::Contains("interrupted bake"));
  const auto other = with(bake, {"--max-error", "0.25", "--resume"});
  CHECK_THAT(place.expect_refusal(other).err, Catch::Contains("another's"));
  CHECK(test::read_bytes(cut + ".part") == part);

  const Ran resumed = run_cairn(with(bake, {"--resume", "--json"}));
  INFO(resumed.err);
  REQUIRE(resumed.exit_code == 0);
  CHECK(nlohmann::json::parse(resumed.out)["resumed"] == true);
  CHECK(test::read_bytes(cut) == test::read_bytes(whole));
  CHECK_FALSE(fs::exists(cut + ".part"));
  CHECK_FALSE(fs::exists(cut + ".journal"));
}

TEST_CASE("bake --force discards the work of an interrupted bake") {
  const Workplace place;
  const std::string whole = place.at("whole.cairn"), cut = place.at("cut.cairn");
  REQUIRE(run_cairn(small_units(place.dem.string(), whole)).exit_code == 0);
  const auto bake = small_units(place.dem.string(), cut);
  REQUIRE(test::run_cairn_on_full_disk(bake, fs::file_size(whole) / 2).exit_code == 1);
  REQUIRE(fs::exists(cut + ".journal"));
  const Ran anew = run_cairn(with(bake, {"--force", "--json"}));
  REQUIRE(anew.exit_code == 0);
  CHECK(nlohmann::json::parse(anew.out)["resumed"] == false);
  CHECK(test::read_bytes(cut) == test::read_bytes(whole));
}

TEST_CASE("an error bound that is not kept costs nothing but the last step") {
  const Workplace place;
  const std::string target = place.at("a.cairn");
  const std::vector<std::string> bake{"bake", place.dem.string(), "-o", target, "--level", "1"};
  const Ran failed = run_cairn(bake);
  INFO(failed.err);
  REQUIRE(failed.exit_code == 1);
  CHECK(is_one_line(failed.err));
  CHECK_THAT(failed.err, Catch::Contains("accuracy") && Catch::Contains("--resume"));
  const Ran allowed = run_cairn(with(bake, {"--resume", "--allow-error", "--json"}));
  REQUIRE(allowed.exit_code == 0);
  CHECK(nlohmann::json::parse(allowed.out)["resumed"] == true);
}

}  // namespace cairn
