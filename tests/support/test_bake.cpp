#include "tests/support/test_bake.h"

#include <utility>

#include <catch2/catch.hpp>

namespace cairn::test {

BuildOptions bake_options(std::vector<std::filesystem::path> dems, const std::filesystem::path& target) {
  BuildOptions options;
  options.inputs = std::move(dems);
  options.target = target;
  options.threads = 2;
  options.force = true;
  return options;
}

void bake(const BuildOptions& options) {
  const auto report = build(options, [](const Progress&) {});
  INFO((report.ok() ? "" : report.error().message));
  REQUIRE(report.ok());
}

}  // namespace cairn::test
