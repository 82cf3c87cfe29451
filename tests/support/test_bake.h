#pragma once

#include <filesystem>
#include <vector>

#include "cairn/build.h"

namespace cairn::test {

/// Two threads, over what is there.
BuildOptions bake_options(std::vector<std::filesystem::path> dems, const std::filesystem::path& target);

/// build() without a progress bar. Fails the test where it fails.
void bake(const BuildOptions& options);

}  // namespace cairn::test
