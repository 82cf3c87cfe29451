// `cairn inspect`: what it says of DEMs with faults that were put into them.

#include <cmath>
#include <filesystem>
#include <functional>

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::run_cairn;

void write_cell(const fs::path& path, const std::function<int(int column, int row)>& height) {
  std::vector<std::byte> bytes;
  for (int row = 0; row < 1201; ++row) {
    for (int column = 0; column < 1201; ++column) {
      const int value = height(column, row);
      bytes.push_back(static_cast<std::byte>(value >> 8 & 0xFF));
      bytes.push_back(static_cast<std::byte>(value & 0xFF));
    }
  }
  test::write_bytes(path, bytes);
}

// Tilted, so that no height is level at many places.
int hills(int column, int row) {
  return static_cast<int>(
      std::lround(800 + 0.31 * column - 0.27 * row + 90 * std::sin(column / 37.0) * std::cos(row / 23.0)));
}

}  // namespace

TEST_CASE("inspect finds voids, spikes, steps, level ground and seams where they are") {
  const test::TempDir dir;
  // A void corner of 100 posts, a spike, everything south of row 700 lifted by 12 m, a lake of 50 x 50.
  write_cell(dir.path() / "N36E028.hgt", [](int column, int row) {
    if (column < 10 && row < 10) return -32768;
    if (column == 333 && row == 444) return 3000;
    if (column >= 900 && column < 950 && row >= 100 && row < 150) return 777;
    return hills(column, row) + (row > 700 ? 12 : 0);
  });
  // Its neighbour's first column is its last, 3 m higher.
  write_cell(dir.path() / "N36E029.hgt",
             [](int column, int row) { return hills(column + 1200, row) + (row > 700 ? 12 : 0) + 3; });
  const auto ran = run_cairn({"inspect", dir.path().string(), "--json"});
  INFO(ran.err);
  REQUIRE(ran.exit_code == 0);
  const json report = json::parse(ran.out);
  REQUIRE(report["rasters"].size() == 2);
  const json& raster = report["rasters"][0];
  CHECK(raster["format"] == "hgt");
  CHECK(raster["posts"] == 1201 * 1201);
  CHECK(raster["voids"] == 100);
  CHECK(raster["highest_m"] == 3000);
  CHECK(raster["only_whole_metres"] == true);
  CHECK(raster["level_m"] == 777);
  CHECK(raster["level_posts"] >= 49 * 49);
  CHECK(raster["spikes"] == 1);
  CHECK(raster["highest_spikes"][0]["column"] == 333);
  CHECK(raster["highest_spikes"][0]["row"] == 444);
  CHECK(raster["highest_spikes"][0]["lon"].get<double>() == Approx(28 + 333 / 1200.0));
  REQUIRE(raster["steps"].size() == 1);
  CHECK(raster["steps"][0]["after_row"] == 700);
  CHECK(raster["steps"][0]["metres"].get<double>() == Approx(12).margin(0.5));
  CHECK(report["rasters"][1]["spikes"] == 0);
  REQUIRE(report["seams"].size() == 1);
  CHECK(report["seams"][0]["posts"] == 1201);
  CHECK(report["seams"][0]["mean_m"] == 3.0);
  CHECK(report["seams"][0]["max_m"] == 3.0);

  const auto text = run_cairn({"inspect", dir.path().string()});
  CHECK(text.exit_code == 0);
  for (const char* part : {"N36E028.hgt", "spikes: 1", "behind row 700", "1201 posts in common"})
    CHECK_THAT(text.out, Catch::Contains(part));
}

TEST_CASE("inspect finds nothing in a clean DEM, and refuses what is no DEM") {
  const test::TempDir dir;
  write_cell(dir.path() / "N36E028.hgt", hills);
  const auto ran = run_cairn({"inspect", (dir.path() / "N36E028.hgt").string(), "--json"});
  REQUIRE(ran.exit_code == 0);
  const json raster = json::parse(ran.out)["rasters"][0];
  CHECK(raster["spikes"] == 0);
  CHECK(raster["steps"].empty());
  CHECK(raster["voids"] == 0);
  CHECK(json::parse(ran.out)["seams"].empty());
  CHECK(run_cairn({"inspect"}).exit_code == 2);
  const auto missing = run_cairn({"inspect", "/nowhere.tif"});
  CHECK(missing.exit_code == 3);
  CHECK(test::is_one_line(missing.err));
}

}  // namespace cairn
