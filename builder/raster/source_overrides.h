#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "cairn/source_rule.h"

namespace cairn {

/// Whether the file's name, or its whole path, matches a pattern as in a shell.
bool matches_glob(const std::filesystem::path& file, const std::string& glob);

/// What the rules say of a source together; of two that match, the later one wins, field by field.
SourceOverrides overrides_of(const std::filesystem::path& source, std::span<const SourceRule> rules);

}  // namespace cairn
