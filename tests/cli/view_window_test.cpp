// A real window on a display of its own, keys pressed, its pictures compared with those that need no display.

#include <cstdlib>
#include <filesystem>

#include <catch2/catch.hpp>
#include <sys/wait.h>

#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn::test {

TEST_CASE(
    "a window obeys its keys, shows what a screenshot shows, and survives being one pixel large and "
    "minimised") {
  const TempDir dir;
  const std::string pack = (dir.path() / "hills.cairn").string(), camera = "28.5,37.2,9000,0,-40";
  std::vector<TileId> tiles;
  for (std::int32_t y = 0; y < 4; ++y) {
    for (std::int32_t x = 0; x < 4; ++x) tiles.push_back({2, 208 * 4 + x, 127 * 4 + y});
  }
  write_test_pack(pack, {257, 2, hills, {}}, with_ancestors(tiles, 0));
  const std::string png = (dir.path() / "headless.png").string();
  REQUIRE(
      run_cairn({"view", pack, "--camera=" + camera, "--size", "320x240", "--screenshot", png}).exit_code ==
      0);
  const std::string command = std::string(CAIRN_WINDOW_SESSION) + " " + CAIRN_PROGRAM + " " + pack + " " +
                              dir.path().string() + " " + camera;
  const int status = std::system(command.c_str());
  REQUIRE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 77) {
    WARN("SKIPPED, nothing was checked: Xvfb or xdotool is not installed");
    return;
  }
  REQUIRE(WEXITSTATUS(status) == 0);
  const auto picture = [&](const char* name) { return read_bytes(dir.path() / name); };
  CHECK(picture("first.png") == read_bytes(png));
  CHECK(picture("wireframe.png") != picture("first.png"));  // F4
  CHECK(picture("again.png") ==
        picture("first.png"));  // F4 again, after it was one pixel large and minimised
  CHECK(picture("ahead.png") != picture("first.png"));  // W
}

}  // namespace cairn::test
