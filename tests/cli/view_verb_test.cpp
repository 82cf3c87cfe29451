// cairn view, which is the program cairn-view beside cairn: pictures and flights without a display.

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <catch2/catch.hpp>

#include "cairn/pack_reader.h"
#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

/// Three levels of hills about 28.5°E 37.5°N.
std::string hill_pack(const TempDir& dir) {
  const auto path = dir.path() / "hills.cairn";
  std::vector<TileId> tiles;
  for (std::int32_t y = 0; y < 4; ++y) {
    for (std::int32_t x = 0; x < 4; ++x) tiles.push_back({2, 208 * 4 + x, 127 * 4 + y});
  }
  write_test_pack(path, {257, 2, hills, {}}, with_ancestors(tiles, 0));
  return path.string();
}

constexpr const char* kCamera = "--camera=28.5,37.2,9000,0,-40";

/// The bytes of a PNG's header that give its size, as text; empty where it is none.
std::string png_size(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(in), {});
  if (bytes.size() < 24 || bytes.compare(1, 3, "PNG") != 0) return {};
  const auto number = [&](std::size_t at) {
    return std::to_string(static_cast<unsigned char>(bytes[at + 2]) * 256 +
                          static_cast<unsigned char>(bytes[at + 3]));
  };
  return number(16) + "x" + number(20);
}

std::string write_flight(const TempDir& dir, double seconds) {
  const auto path = dir.path() / "flight.json";
  std::ofstream(path) << R"({"frames_per_second":10,"keys":[)"
                      << R"({"time":0,"lon":28.5,"lat":37.2,"height":9000,"heading":0,"pitch":-40},)"
                      << R"({"time":)" << seconds
                      << R"(,"lon":28.6,"lat":37.4,"height":4000,"heading":40,"pitch":-30}]})";
  return path.string();
}

}  // namespace

TEST_CASE("cairn view --screenshot draws a picture of the size asked for, the same each time") {
  const TempDir dir;
  const std::string pack = hill_pack(dir);
  const std::string a = (dir.path() / "a.png").string(), b = (dir.path() / "b.png").string();
  const Ran ran = run_cairn({"view", pack, kCamera, "--size", "200x150", "--screenshot", a});
  INFO(ran.err);
  REQUIRE(ran.exit_code == 0);
  CHECK(png_size(a) == "200x150");
  CHECK(is_one_line(ran.err));  // that it has no imagery
  REQUIRE(run_cairn({"view", pack, kCamera, "--size", "200x150", "--screenshot", b}).exit_code == 0);
  CHECK(read_bytes(a) == read_bytes(b));
  REQUIRE(run_cairn({"view", pack, "--size", "1x1", "--screenshot", b}).exit_code == 0);
  CHECK(png_size(b) == "1x1");
}

TEST_CASE("cairn view refuses what it cannot do in one line, by exit code") {
  const TempDir dir;
  const std::string pack = hill_pack(dir), png = (dir.path() / "a.png").string();
  const auto code = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "view");
    const Ran ran = run_cairn(arguments);
    CAPTURE(arguments, ran.err);
    CHECK(!ran.err.empty());
    return ran.exit_code;
  };
  CHECK(code({pack, "--camera=1,2,3", "--screenshot", png}) == 2);
  CHECK(code({pack, "--camera=1,95,3,0,0", "--screenshot", png}) == 2);
  CHECK(code({pack, "--size", "0x10", "--screenshot", png}) == 2);
  CHECK(code({pack, "--hole-colour", "mauve", "--screenshot", png}) == 2);
  CHECK(code({pack, "--method", "best", "--screenshot", png}) == 2);
  CHECK(code({pack, "--cache", "1", "--screenshot", png}) == 2);
  const auto pack_bytes = std::filesystem::file_size(pack);
  std::filesystem::create_symlink(pack, dir.path() / "link.png");
  CHECK(code({pack, "--screenshot", pack}) == 2);
  CHECK(code({pack, "--screenshot", (dir.path() / "link.png").string()}) == 2);
  const std::string flight = write_flight(dir, 1);
  const auto flight_bytes = std::filesystem::file_size(flight);
  CHECK(code({pack, "--flight", flight, "--stats", flight}) == 2);
  CHECK(std::filesystem::file_size(pack) == pack_bytes);
  CHECK(std::filesystem::file_size(flight) == flight_bytes);
  CHECK(code({pack, "--no-such-option"}) == 2);
  CHECK(code({(dir.path() / "absent.cairn").string(), "--screenshot", png}) != 0);
  CHECK(code({pack, "--screenshot", (dir.path() / "no" / "folder.png").string()}) == 1);
  std::ofstream(dir.path() / "no.cairn") << "this is no pack, however long it may be, and it is long enough";
  CHECK(code({(dir.path() / "no.cairn").string(), "--screenshot", png}) == 3);
  std::ofstream(dir.path() / "bad.json") << "{}";
  CHECK(code({pack, "--flight", (dir.path() / "bad.json").string(), "--stats",
              (dir.path() / "s.csv").string()}) == 3);
}

TEST_CASE(
    "cairn view --method draws another mesh of the same ground, and names the methods where it is none") {
  const TempDir dir;
  const std::string pack = hill_pack(dir), png = (dir.path() / "a.png").string(),
                    own = (dir.path() / "own.png").string();
  const Ran ran = run_cairn({"view", pack, kCamera, "--method", "soar", "--tolerance", "4", "--size",
                             "200x150", "--screenshot", png});
  INFO(ran.err);
  REQUIRE(ran.exit_code == 0);
  CHECK(png_size(png) == "200x150");
  REQUIRE(run_cairn({"view", pack, kCamera, "--tolerance", "4", "--wireframe", "--size", "200x150",
                     "--screenshot", own})
              .exit_code == 0);
  REQUIRE(run_cairn({"view", pack, kCamera, "--method", "soar", "--tolerance", "4", "--wireframe", "--size",
                     "200x150", "--screenshot", png})
              .exit_code == 0);
  CHECK(read_bytes(png) != read_bytes(own));
  const Ran none = run_cairn({"view", pack, "--method", "best", "--screenshot", png});
  CHECK(is_one_line(none.err));
  for (const char* name : {"block", "cairn", "cdlod", "chunked", "clipmap", "full", "geomip", "quadtree",
                           "roam", "rqt", "soar", "surface"}) {
    CHECK(none.err.find(name) != std::string::npos);
  }
}

TEST_CASE("cairn view --flight writes a picture and a row of statistics a frame") {
  const TempDir dir;
  const std::string pack = hill_pack(dir), csv = (dir.path() / "stats.csv").string();
  std::filesystem::create_directory(dir.path() / "frames");
  const Ran ran = run_cairn({"view", pack, "--flight", write_flight(dir, 1), "--frames",
                             (dir.path() / "frames").string(), "--stats", csv, "--size", "80x60"});
  INFO(ran.err);
  REQUIRE(ran.exit_code == 0);
  const std::string rows = text_of(csv);
  CHECK(std::count(rows.begin(), rows.end(), '\n') == 1 + 11);
  int frames = 0;
  for (const auto& file : std::filesystem::directory_iterator(dir.path() / "frames")) {
    frames += png_size(file.path()) == "80x60";
  }
  CHECK(frames == 11);
}

TEST_CASE("cairn view --video makes a film with ffmpeg, or says that there is none") {
  const TempDir dir;
  const std::string pack = hill_pack(dir), film = (dir.path() / "film.mp4").string();
  const Ran ran =
      run_cairn({"view", pack, "--flight", write_flight(dir, 1), "--video", film, "--size", "80x60"});
  INFO(ran.err);
  if (std::system("ffmpeg -version >/dev/null 2>&1") != 0) {
    WARN("SKIPPED, no film was checked: ffmpeg is not installed");
    CHECK(ran.exit_code == 1);
    CHECK(ran.err.find("ffmpeg") != std::string::npos);
    return;
  }
  REQUIRE(ran.exit_code == 0);
  const std::string frames = (dir.path() / "frames").string();
  const std::string probe =
      "ffprobe -v error -count_frames -select_streams v -show_entries "
      "stream=nb_read_frames,width,height -of csv=p=0 '" +
      film + "' > '" + frames + "'";
  REQUIRE(std::system(probe.c_str()) == 0);
  CHECK(text_of(frames) == "80,60,11\n");
}

TEST_CASE("cairn view names each damaged tile once and draws the rest") {
  const TempDir dir;
  const std::string pack = hill_pack(dir), png = (dir.path() / "a.png").string();
  Result<PackReader> reader = PackReader::open(pack);
  REQUIRE(reader.ok());
  auto bytes = read_bytes(pack);
  for (std::size_t i = 0; i < reader->entry_count(); ++i) {
    const IndexEntry entry = reader->entry(i);
    if (entry.id.level == 2) bytes[entry.offset + entry.bytes / 2] ^= std::byte{1};
  }
  write_bytes(pack, bytes);
  const Ran ran = run_cairn({"view", pack, "--camera=28.5,37.5,2500,0,-60", "--screenshot", png});
  CHECK(ran.exit_code == 0);
  const auto damaged = std::count(ran.err.begin(), ran.err.end(), '\n') - 1;  // and one line on imagery
  CHECK(damaged >= 1);
  CHECK(damaged <= 16);
}

}  // namespace cairn::test
