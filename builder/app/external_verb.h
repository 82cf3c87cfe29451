#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string_view>

namespace cairn {

struct ExternalVerb {
  const char* name;
  const char* summary;
};

/// The verbs that are programs of their own, as `cairn --help` lists them.
inline constexpr std::array<ExternalVerb, 3> kExternalVerbs{{
    {"view", "Fly over a pack, in a window or into pictures and films"},
    {"stats", "Count the blocks of scene maps and what a move of the eye loads"},
    {"lab", "Measure level-of-detail methods on a pack's tiles"},
}};

/// The program `cairn-VERB` beside this one, if it is there: verbs that the program does not have itself, as
/// git has them.
std::optional<std::filesystem::path> find_external_verb(std::string_view verb);

/// Becomes that program, with the arguments from the verb on. Returns only where that fails.
void become(const std::filesystem::path& program, char** arguments);

}  // namespace cairn
