// `cairn bake --memory` against what the kernel says of the process, and `--dry-run` against the bake.

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <catch2/catch.hpp>
#include <fcntl.h>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/run_program.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::run_cairn;

constexpr int kPosts = 3601;

// Rugged ground in whole metres, on every post of an SRTM cell of one second: 25 MiB.
void write_cell(const fs::path& path) {
  std::vector<std::byte> bytes;
  bytes.reserve(std::size_t{2} * kPosts * kPosts);
  for (int r = 0; r < kPosts; ++r) {
    for (int c = 0; c < kPosts; ++c) {
      const double height = 1500 + 700 * std::sin(r / 211.0) * std::cos(c / 173.0) +
                            90 * std::sin(r / 9.0 + c / 7.0) + (r * 7919 + c * 104729) % 11;
      const auto metres = static_cast<int>(height);
      bytes.push_back(static_cast<std::byte>(metres >> 8));
      bytes.push_back(static_cast<std::byte>(metres & 255));
    }
  }
  test::write_bytes(path, bytes);
}

// The largest resident size of a run of `cairn`, as the kernel counts it (VmHWM), in MiB.
double peak_mib_of(const std::vector<std::string>& arguments) {
  const pid_t child = ::fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    std::vector<char*> words{const_cast<char*>(CAIRN_PROGRAM)};
    for (const std::string& a : arguments) words.push_back(const_cast<char*>(a.c_str()));
    words.push_back(nullptr);
    const int nowhere = ::open("/dev/null", O_WRONLY);
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
    ::execv(CAIRN_PROGRAM, words.data());
    ::_exit(127);
  }
  int status = 0;
  rusage usage{};
  REQUIRE(::wait4(child, &status, 0, &usage) == child);
  REQUIRE(WIFEXITED(status));
  REQUIRE(WEXITSTATUS(status) == 0);
  return static_cast<double>(usage.ru_maxrss) / 1024;
}

}  // namespace

TEST_CASE("a bake stays under --memory by the kernel's count") {
  const test::TempDir dir;
  const fs::path cell = dir.path() / "N36W085.hgt";
  write_cell(cell);
  for (const int mebibytes : {96, 256}) {
    const double peak = peak_mib_of({"bake", cell.string(), "-o", (dir.path() / "a.cairn").string(),
                                     "--force", "--threads", "2", "--memory", std::to_string(mebibytes)});
    INFO(peak << " MiB");
    CHECK(peak < mebibytes);
  }
}

TEST_CASE("the bytes that --dry-run foresees are those of the bake, within 30 %") {
  const test::TempDir dir;
  const fs::path cell = dir.path() / "N36W085.hgt";
  write_cell(cell);
  const std::string out = (dir.path() / "a.cairn").string();
  const auto dry = run_cairn({"bake", cell.string(), "-o", out, "--dry-run", "--json"});
  REQUIRE(dry.exit_code == 0);
  const json foreseen = json::parse(dry.out);
  CHECK_FALSE(fs::exists(out));
  const auto bake = run_cairn({"bake", cell.string(), "-o", out, "--json"});
  REQUIRE(bake.exit_code == 0);
  const json baked = json::parse(bake.out);
  CHECK(foreseen["samples"] == baked["samples"]);
  CHECK(foreseen["quantum_m"] == baked["quantum_m"]);
  CHECK(foreseen["error_bound_m"] == baked["error_bound_m"]);
  std::uint64_t tiles = 0;
  for (const json& level : foreseen["levels"]) tiles += level["tiles"].get<std::uint64_t>();
  CHECK(tiles > 60);
  const double share = foreseen["estimated_bytes"].get<double>() / baked["file_bytes"].get<double>();
  INFO(share);
  CHECK(share > 0.7);
  CHECK(share < 1.3);
}

}  // namespace cairn
