// What a person says of DEMs on the command line: which files, and what counts instead of what they say.

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"
#include "tests/support/test_data.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::run_cairn;

void write_lines(const fs::path& path, const std::string& text) {
  std::ofstream(path) << text;
}

json info_of(const std::string& pack) {
  const auto info = run_cairn({"info", pack, "--json"});
  REQUIRE(info.exit_code == 0);
  return json::parse(info.out);
}

double height_at_middle(const std::string& pack) {
  const json bounds = info_of(pack)["bounds"];
  const double lon = (bounds["west"].get<double>() + bounds["east"].get<double>()) / 2;
  const double lat = (bounds["south"].get<double>() + bounds["north"].get<double>()) / 2;
  const auto ran = run_cairn({"sample", pack, std::to_string(lon), std::to_string(lat), "--json"});
  INFO(ran.err);
  REQUIRE(ran.exit_code == 0);
  return json::parse(ran.out)["height"].get<double>();
}

}  // namespace

TEST_CASE("a unit that is told counts, is in the metadata and in what info prints") {
  const test::TempDir dir;
  const fs::path dem = test::sample_dem() / "jacksboro_fault.tif";
  const std::string pack = (dir.path() / "a.cairn").string(), feet = (dir.path() / "b.cairn").string();
  REQUIRE(run_cairn({"bake", dem.string(), "-o", pack}).exit_code == 0);
  const fs::path sources = dir.path() / "sources.txt";
  write_lines(sources, "# feet\njacks*.tif  unit=\"US survey foot\"  # that is all\n\n");
  for (const std::vector<std::string>& told :
       {std::vector<std::string>{"--unit", "US survey foot"}, {"--sources", sources.string()}}) {
    std::vector<std::string> arguments{"bake", dem.string(), "-o", feet, "--force"};
    arguments.insert(arguments.end(), told.begin(), told.end());
    const auto ran = run_cairn(arguments);
    INFO(ran.err);
    REQUIRE(ran.exit_code == 0);
    CHECK(height_at_middle(feet) == Approx(height_at_middle(pack) * 1200 / 3937).margin(0.6));
    CHECK(info_of(feet)["sources"][0]["overrides"]["unit"] == "US survey foot");
    CHECK(run_cairn({"info", feet}).out.find("told {\"unit\":\"US survey foot\"}") != std::string::npos);
  }
}

TEST_CASE("posts below a sea that is told are raised to it, for all sources or those of a pattern") {
  const test::TempDir dir;
  const fs::path dem = test::sample_dem() / "jacksboro_fault.tif";
  const std::string pack = (dir.path() / "a.cairn").string();
  const fs::path sources = dir.path() / "sources.txt";
  write_lines(sources, "jacks*.tif  sea-clamp=4000\n");
  for (const std::vector<std::string>& told :
       {std::vector<std::string>{"--sea-clamp", "4000"}, {"--sources", sources.string()}}) {
    std::vector<std::string> arguments{"bake", dem.string(), "-o", pack, "--force"};
    arguments.insert(arguments.end(), told.begin(), told.end());
    REQUIRE(run_cairn(arguments).exit_code == 0);
    CHECK(height_at_middle(pack) == Approx(4000).margin(0.5));
    CHECK(info_of(pack)["sources"][0]["overrides"]["sea_clamp_m"] == 4000);
    const auto verified = run_cairn({"verify", pack, "--against", dem.string()});
    INFO(verified.out << verified.err);
    CHECK(verified.exit_code == 0);
  }
  // A sea below all posts changes none.
  REQUIRE(run_cairn({"bake", dem.string(), "-o", pack, "--force"}).exit_code == 0);
  const double unclamped = height_at_middle(pack);
  REQUIRE(run_cairn({"bake", dem.string(), "-o", pack, "--force", "--sea-clamp", "-500"}).exit_code == 0);
  CHECK(height_at_middle(pack) == unclamped);
}

TEST_CASE("files are chosen by --include and --exclude, and none left is an error") {
  const test::TempDir dir;
  fs::copy(test::sample_dem() / "jacksboro_fault.tif", dir.path() / "a.tif");
  fs::copy(test::sample_dem() / "jacksboro_fault.tif", dir.path() / "b.tif");
  const test::TempDir out;
  const std::string pack = (out.path() / "o.cairn").string();
  REQUIRE(run_cairn({"bake", dir.path().string(), "-o", pack, "--exclude", "a*"}).exit_code == 0);
  CHECK(info_of(pack)["sources"].size() == 1);
  CHECK(info_of(pack)["sources"][0]["name"] == "b.tif");
  REQUIRE(run_cairn({"bake", "--include", "a*", dir.path().string(), "-o", pack, "--force"}).exit_code == 0);
  CHECK(info_of(pack)["sources"][0]["name"] == "a.tif");
  const auto none = run_cairn({"bake", dir.path().string(), "-o", pack, "--force", "--include", "c*"});
  CHECK(none.exit_code == 2);
  CHECK(none.err.find("found none of 2") != std::string::npos);
}

TEST_CASE("what is told wrongly is refused, with the line of the file") {
  const test::TempDir dir;
  const std::string dem = (test::sample_dem() / "jacksboro_fault.tif").string();
  const std::string pack = (dir.path() / "a.cairn").string();
  const fs::path sources = dir.path() / "sources.txt";
  const auto refused = [&](const std::vector<std::string>& told) {
    std::vector<std::string> arguments{"bake", dem, "-o", pack};
    arguments.insert(arguments.end(), told.begin(), told.end());
    const auto ran = run_cairn(arguments);
    CHECK(ran.exit_code != 0);
    CHECK_FALSE(fs::exists(pack));
    return ran.err;
  };
  for (const char* line : {"*.tif unit", "*.tif colour=red", "*.tif", "*.tif nodata=x", "*.tif nodata=nan",
                           "*.tif band=1.5", "*.tif unit="}) {
    INFO(line);
    write_lines(sources, std::string("\n") + line + "\n");
    CHECK(refused({"--sources", sources.string()}).find("sources.txt: line 2: expected") !=
          std::string::npos);
  }
  write_lines(sources, "other*.tif unit=m\n");
  CHECK(refused({"--sources", sources.string()}).find("found other*.tif") != std::string::npos);
  CHECK(refused({"--band", "7"}).find("expected band 7") != std::string::npos);
  CHECK(refused({"--unit", "furlong"}).find("found furlong") != std::string::npos);
  CHECK(refused({"--source-crs", "EPSG:1"}).find("CRS: expected") != std::string::npos);
  CHECK_FALSE(refused({"--nodata", "inf"}).empty());
  CHECK_FALSE(refused({"--band", "0"}).empty());
  CHECK_FALSE(refused({"--fade", "-1"}).empty());
}

TEST_CASE("sample prints heights above the ellipsoid or the geoid, as asked") {
  const test::TempDir dir;
  // A geoid 30 m above the ellipsoid everywhere, in GeographicLib's format.
  std::ofstream geoid(dir.path() / "egm96-5.pgm", std::ios::binary);
  geoid << "P5\n# Description level\n# Offset -108\n# Scale 0.003\n24 13\n65535\n";
  for (int post = 0; post < 24 * 13; ++post)
    geoid.put(static_cast<char>(46000 >> 8)).put(static_cast<char>(46000 & 255));
  geoid.close();
  const std::string dem = (test::sample_dem() / "jacksboro_fault.tif").string();
  const std::string pack = (dir.path() / "a.cairn").string();
  const auto height = [&](const std::string& datum) {
    std::vector<std::string> arguments{"sample", pack, "-84.2", "36.6"};
    if (!datum.empty()) arguments.insert(arguments.end(), {"--datum", datum});
    return run_cairn(arguments);
  };
  ::setenv("GEOGRAPHICLIB_GEOID_PATH", dir.path().c_str(), 1);
  REQUIRE(run_cairn({"bake", dem, "-o", pack, "--datum", "egm96"}).exit_code == 0);
  const double stored = std::stod(height("").out);
  CHECK(std::stod(height("orthometric").out) == stored);
  CHECK(std::stod(height("ellipsoid").out) == Approx(stored + 30).margin(1e-3));
  REQUIRE(run_cairn({"bake", dem, "-o", pack, "--datum", "ellipsoid", "--force"}).exit_code == 0);
  CHECK(std::stod(height("ellipsoid").out) == stored);
  CHECK(std::stod(height("orthometric").out) == Approx(stored - 30).margin(1e-3));
  const auto table = run_cairn({"sample", pack, "--points", "-", "--datum", "orthometric"}, "-84.2,36.6\n");
  CHECK(table.out.find(height("orthometric").out.substr(0, 6)) != std::string::npos);
  REQUIRE(run_cairn({"bake", dem, "-o", pack, "--datum", "unknown", "--force"}).exit_code == 0);
  CHECK(height("ellipsoid").exit_code == 2);
  CHECK(std::stod(height("").out) == stored);
  fs::remove(dir.path() / "egm96-5.pgm");
  REQUIRE(run_cairn({"bake", dem, "-o", pack, "--datum", "egm96", "--force"}).exit_code == 0);
  const auto without = height("ellipsoid");
  CHECK(without.exit_code == 1);
  CHECK(without.err.find("expected GeographicLib's egm96-5") != std::string::npos);
  ::unsetenv("GEOGRAPHICLIB_GEOID_PATH");
}

}  // namespace cairn
