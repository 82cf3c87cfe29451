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

/// The file beside a pack that keeps what its units were made of.
std::filesystem::path units_path(const std::filesystem::path& pack);

/// Refuses a target that is an input, or whose unfinished pack, journal or kept units are one. No option changes that.
Status check_target_is_no_input(const std::filesystem::path& target,
                                std::span<const std::filesystem::path> inputs);

/// Refuses a target that a bake must not replace. Beyond inputs these are: what exists, without
/// `options.force`; what is no pack, with it; a TARGET.part, TARGET.journal or TARGET.units that no bake wrote; and the
/// work of an interrupted bake, unless it is to be resumed or `options.force` is set.
Status check_target(const SessionOptions& options, std::span<const std::filesystem::path> inputs);

/// check_target() for a part of a bake, which is made in its journal: TARGET.journal becomes TARGET.
Status check_part_target(const SessionOptions& options, std::span<const std::filesystem::path> inputs);

}  // namespace cairn
