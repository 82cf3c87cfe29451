#pragma once

#include <filesystem>
#include <span>
#include <string_view>

#include "cairn/session_options.h"
#include "cairn/status.h"

namespace cairn {

/// How the errors of check_target() end that `options.force` or `options.resume` can change.
inline constexpr std::string_view kTargetExists = ": expected no such file, found one";
inline constexpr std::string_view kWorkExists =
    ": expected no such file, found the work of an interrupted bake";

/// Refuses a target that is an input, or whose unfinished pack or journal is one. No option changes that.
Status check_target_is_no_input(const std::filesystem::path& target,
                                std::span<const std::filesystem::path> inputs);

/// Refuses a target that a bake must not replace. Beyond inputs these are: what exists, without
/// `options.force`; what is no pack, with it; a TARGET.part or TARGET.journal that no bake wrote; and the
/// work of an interrupted bake, unless it is to be resumed or `options.force` is set.
Status check_target(const SessionOptions& options, std::span<const std::filesystem::path> inputs);

}  // namespace cairn
