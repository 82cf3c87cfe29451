#pragma once

#include <filesystem>
#include <span>

#include "cairn/status.h"

namespace cairn {

/// Returns whether both names lead to one existing file. Symbolic and hard links, relative names and file
/// systems that ignore case are all seen through, since the file's device and number are compared.
bool is_same_file(const std::filesystem::path& a, const std::filesystem::path& b);

/// Refuses, as wrong usage, an output whose name leads to one of the files that are read. Nothing that a
/// caller can ask for makes such an output right.
Status check_is_no_input(const std::filesystem::path& output, std::span<const std::filesystem::path> inputs);

/// Refuses, as wrong usage, an output that is a folder or lies in no folder: the work would be lost at its
/// end.
Status check_can_be_file(const std::filesystem::path& output);

}  // namespace cairn
