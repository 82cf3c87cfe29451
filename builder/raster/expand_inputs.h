#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "cairn/status.h"

namespace cairn {

/// Files named directly, by folder (searched without descending, known extensions only), or by a glob pattern
/// in the last component; in the order given, each folder or glob sorted by name. bad_data where one matches
/// nothing.
Result<std::vector<std::filesystem::path>> expand_inputs(std::span<const std::string> arguments);

}  // namespace cairn
