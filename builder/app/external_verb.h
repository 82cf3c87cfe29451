#pragma once

#include <filesystem>
#include <optional>
#include <string_view>

namespace cairn {

/// The program `cairn-VERB` beside this one, if it is there: verbs that the program does not have itself, as
/// git has them.
std::optional<std::filesystem::path> find_external_verb(std::string_view verb);

/// Becomes that program, with the arguments from the verb on. Returns only where that fails.
void become(const std::filesystem::path& program, char** arguments);

}  // namespace cairn
