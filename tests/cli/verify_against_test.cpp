// `cairn verify --against`: the pack is measured with the options that its metadata state.

#include <filesystem>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "tests/support/run_program.h"
#include "tests/support/test_data.h"

namespace cairn {
namespace {

using test::Ran;
using test::run_cairn;

std::string fault() {
  return (test::sample_dem() / "jacksboro_fault.tif").string();
}

// The whole Earth: stands in for a geoid, of which the test wants only that it is there.
std::string earth() {
  return (test::sample_dem() / "etopo5_thinned.tif").string();
}

}  // namespace

TEST_CASE("a pack verifies against its sources whatever options it was baked with") {
  const test::TempDir dir;
  const std::string pack = (dir.path() / "a.cairn").string();
  for (const std::vector<std::string>& options :
       std::vector<std::vector<std::string>>{{"--max-error", "0.2", "--quantum", "0.1"},
                                             {"--tile-size", "257", "--level", "4", "--top", "-3"},
                                             {"--region", "-84.4,36.2,-84.3,36.3"},
                                             {"--resampling", "bilinear", "--max-error", "500"}}) {
    std::vector<std::string> bake{"bake", fault(), "-o", pack, "--force"};
    bake.insert(bake.end(), options.begin(), options.end());
    const Ran baked = run_cairn(bake);
    INFO(options[0] << ": " << baked.err);
    REQUIRE(baked.exit_code == 0);
    const Ran verified = run_cairn({"verify", pack, "--against", fault()});
    INFO(verified.out << verified.err);
    CHECK(verified.exit_code == 0);
  }
}

TEST_CASE("a pack of ellipsoidal heights is measured with its geoid, and refused without it") {
  const test::TempDir dir;
  const std::string with = (dir.path() / "with.cairn").string(),
                    without = (dir.path() / "without.cairn").string();
  REQUIRE(run_cairn({"bake", fault(), "-o", with, "--geoid", earth()}).exit_code == 0);
  REQUIRE(run_cairn({"bake", fault(), "-o", without}).exit_code == 0);
  CHECK(run_cairn({"verify", with, "--against", fault(), "--geoid", earth()}).exit_code == 0);
  const Ran forgotten = run_cairn({"verify", with, "--against", fault()});
  CHECK(forgotten.exit_code == 2);
  CHECK_THAT(forgotten.err, Catch::Contains("expected the geoid, as the pack was baked, found none"));
  const Ran unasked = run_cairn({"verify", without, "--against", fault(), "--geoid", earth()});
  CHECK(unasked.exit_code == 2);
  CHECK_THAT(unasked.err, Catch::Contains("expected no geoid, as the pack was baked, found one"));
}

}  // namespace cairn
