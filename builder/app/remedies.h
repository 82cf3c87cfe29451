#pragma once

#include <filesystem>
#include <vector>

#include "cairn/build.h"
#include "cairn/status.h"

namespace cairn {

/// Adds what can be done about an error in the words of the command line. `work` is the file that holds what
/// is baked so far.
Error with_remedies(Error error, const std::vector<Remedy>& remedies, const std::filesystem::path& work);

}  // namespace cairn
