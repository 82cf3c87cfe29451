// cairn lab, which is the program cairn-lab beside cairn.

#include <algorithm>
#include <filesystem>
#include <sstream>

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

std::string pack_in(const std::filesystem::path& folder) {
  test::TestSurface surface;
  surface.height = test::hills;
  const TileId first = tile_at({8, 46}, 2);
  const std::filesystem::path path = folder / "hills.cairn";
  test::write_test_pack(path, surface, test::with_ancestors({first, neighbour_of(first, 1, 0)}, -2));
  return path.string();
}

constexpr const char* kCamera = "8.2,46.1,4000,60,-30";

}  // namespace

TEST_CASE("cairn lab compare writes a line a frame, method and tolerance, and their summary") {
  const test::TempDir dir;
  const std::string out = (dir.path() / "out").string();
  const auto ran =
      run_cairn({"lab", "compare", pack_in(dir.path()), "--flight", "spin", "--methods", "block,geomip",
                 "--tolerance", "1,4", "--size", "320x200", "--frames", "3", "--no-charts", "--out", out});
  REQUIRE(ran.exit_code == 0);
  CHECK(ran.out.empty());
  const std::string csv = text_of(std::filesystem::path(out) / "frames.csv");
  CHECK(std::count(csv.begin(), csv.end(), '\n') == 1 + 3 * 2 * 2);
  const json summary = json::parse(text_of(std::filesystem::path(out) / "summary.json"));
  CHECK(summary["results"].size() == 4);
  for (const json& result : summary["results"]) {
    CHECK(result["frames"] == 3);
    CHECK(result["cracks"]["max"] == 0);
    CHECK(result["holes"]["max"] == 0);
    CHECK(result["triangles"]["max"] > 0);
  }
}

TEST_CASE("cairn lab mesh writes the same surface as OBJ and as PLY") {
  const test::TempDir dir;
  const std::string pack = pack_in(dir.path());
  const std::string obj = (dir.path() / "m.obj").string(), ply = (dir.path() / "m.ply").string();
  for (const std::string& file : {obj, ply}) {
    const auto ran = run_cairn(
        {"lab", "mesh", pack, "--camera", kCamera, "--method", "quadtree", "--tolerance", "2", "-o", file});
    REQUIRE(ran.exit_code == 0);
  }
  std::istringstream lines(text_of(obj));
  std::size_t vertices = 0, faces = 0;
  double west = 1e9, east = -1e9;
  for (std::string line; std::getline(lines, line);) {
    faces += line[0] == 'f';
    if (line[0] != 'v') continue;
    ++vertices;
    const double lon = std::stod(line.substr(2));
    west = std::min(west, lon);
    east = std::max(east, lon);
  }
  CHECK(west == 8);
  CHECK(east >= 8.5);
  CHECK(text_of(ply).find("element vertex " + std::to_string(vertices) + "\n") != std::string::npos);
  CHECK(text_of(ply).find("element face " + std::to_string(faces) + "\n") != std::string::npos);
}

TEST_CASE("cairn lab mesh --cull writes less than the whole map") {
  const test::TempDir dir;
  const std::string pack = pack_in(dir.path()), all = (dir.path() / "all.obj").string(),
                    seen = (dir.path() / "seen.obj").string();
  const std::vector<std::string> mesh{"lab", "mesh", pack, "--camera", kCamera, "--method", "block", "-o"};
  const auto write = [&](const std::vector<std::string>& rest) {
    std::vector<std::string> arguments = mesh;
    arguments.insert(arguments.end(), rest.begin(), rest.end());
    return run_cairn(arguments).exit_code;
  };
  REQUIRE(write({all}) == 0);
  REQUIRE(write({seen, "--cull"}) == 0);
  CHECK(std::filesystem::file_size(seen) < std::filesystem::file_size(all));
}

TEST_CASE("cairn lab names the word that it does not understand, and exits with 2") {
  const test::TempDir dir;
  const std::string pack = pack_in(dir.path()), out = (dir.path() / "out").string();
  const std::vector<std::vector<std::string>> wrong{
      {"lab", "compare", pack, "--methods", "magic", "--out", out},
      {"lab", "compare", pack, "--tolerance", "1,-2", "--out", out},
      {"lab", "compare", pack, "--flight", "nowhere", "--out", out},
      {"lab", "compare", pack, "--size", "12", "--out", out},
      {"lab", "mesh", pack, "--camera", "1,2", "-o", out + ".obj"},
      {"lab", "mesh", pack, "--camera", kCamera, "-o", out + ".stl"},
      {"lab", "mesh", pack, "--camera", kCamera, "--method", "magic", "-o", out + ".obj"},
      {"lab"},
  };
  for (const auto& arguments : wrong) {
    CAPTURE(arguments.back());
    const auto ran = run_cairn(arguments);
    CHECK(ran.exit_code == 2);
    CHECK(is_one_line(ran.err));
  }
  CHECK(run_cairn({"lab", "compare", "missing.cairn", "--out", out}).exit_code != 0);
}

}  // namespace cairn
