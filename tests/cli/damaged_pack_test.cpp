// Every verb that reads a pack, on packs that are cut or have a byte changed: it says so or is not concerned,
// and never crashes.

#include <random>

#include <catch2/catch.hpp>

#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

struct Damaged {
  test::TempDir dir;
  fs::path path = dir.path() / "a.cairn";
  std::vector<std::byte> good;

  Damaged() {
    test::write_test_pack(path, {257, 2, test::hills, {}}, {{1, 4, 2}, {2, 8, 4}, {2, 9, 4}});
    good = test::read_bytes(path);
  }

  std::vector<std::vector<std::string>> verbs() const {
    const std::string picture = (dir.path() / "r.png").string(), tile = (dir.path() / "t.tif").string();
    return {{"info", path},
            {"verify", path},
            {"sample", path, "-177.9", "-88.9"},
            {"extract", path, "2/8/4", "-o", tile},
            {"hillshade", path, "-o", picture, "--size", "200x100"}};
  }
};

}  // namespace

TEST_CASE("no verb crashes on a changed byte, and verify finds each") {
  const Damaged pack;
  std::mt19937 random(8);
  for (int i = 0; i < 12; ++i) {
    auto bytes = pack.good;
    bytes[i < 6 ? random() % bytes.size() : bytes.size() - 1 - random() % 900] ^= std::byte{32};
    test::write_bytes(pack.path, bytes);
    for (const auto& arguments : pack.verbs()) {
      const auto ran = test::run_cairn(arguments);
      INFO(arguments.front() << ": " << ran.err);
      CHECK((ran.exit_code == 3 || (ran.exit_code == 0 && arguments.front() != "verify")));
      if (ran.exit_code == 3 && arguments.front() != "verify") CHECK(test::is_one_line(ran.err));
    }
  }
}

TEST_CASE("every verb refuses a pack that is cut at multiples of 4 KiB") {
  const Damaged pack;
  const std::size_t step =
      4096 * (1 + pack.good.size() / 4096 / 12);  // at most a dozen of them: 5 programs each
  for (std::size_t length = 0; length < pack.good.size(); length += step) {
    test::write_bytes(pack.path,
                      {pack.good.begin(), pack.good.begin() + static_cast<std::ptrdiff_t>(length)});
    for (const auto& arguments : pack.verbs()) CHECK(test::run_cairn(arguments).exit_code == 3);
  }
  CHECK_FALSE(fs::exists(pack.dir.path() / "t.tif"));
  CHECK_FALSE(fs::exists(pack.dir.path() / "r.png"));
}

}  // namespace cairn
