#include "tests/support/test_bake.h"

#include <utility>

#include <catch2/catch.hpp>

namespace cairn::test {

BuildOptions bake_options(std::vector<std::filesystem::path> dems, const std::filesystem::path& target) {
  BuildOptions options;
  options.mosaic.inputs = std::move(dems);
  options.session.target = target;
  options.session.threads = 2;
  options.session.force = true;
  return options;
}

void bake(const BuildOptions& options) {
  const auto report = build(options, [](const Progress&) { return true; });
  INFO((report.ok() ? "" : report.error().message));
  REQUIRE(report.ok());
}

}  // namespace cairn::test
