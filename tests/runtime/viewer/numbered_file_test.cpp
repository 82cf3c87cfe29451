#include "runtime/viewer/numbered_file.h"

#include <filesystem>
#include <fstream>
#include <string>

#include <catch2/catch.hpp>

#include "tests/support/test_data.h"

namespace cairn::viewer {

TEST_CASE("a numbered file is a new one, whatever lies there already") {
  const test::TempDir dir;
  const std::string prefix = (dir.path() / "cairn").string();
  std::ofstream(prefix + "-1.png") << "a picture of the last session";
  std::filesystem::create_symlink(dir.path() / "nowhere", prefix + "-3.png");
  int first = 1;
  for (const int expected : {2, 4, 5}) {
    const auto file = create_numbered(prefix, "png", first);
    REQUIRE(file.ok());
    CHECK(file->number == expected);
    CHECK(file->name == prefix + "-" + std::to_string(expected) + ".png");
    first = file->number;  // taken again, it must be passed over
  }
  CHECK(std::filesystem::file_size(prefix + "-1.png") == 29);
  CHECK_FALSE(std::filesystem::exists(dir.path() / "nowhere"));
}

TEST_CASE("a folder that cannot be written is an error that names the file") {
  const auto file = create_numbered("/nowhere/cairn", "png", 7);
  REQUIRE_FALSE(file.ok());
  CHECK(file.error().message.find("/nowhere/cairn-7.png: create: ") == 0);
}

}  // namespace cairn::viewer
