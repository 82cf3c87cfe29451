#pragma once

#include "cairn/build_options.h"
#include "cairn/status.h"

namespace cairn {

/// Refuses a target that is an input, or whose unfinished pack or journal is one. `options.force` changes
/// nothing of it.
Status check_target_is_no_input(const BuildOptions& options);

/// Refuses a target that a bake must not replace. Beyond inputs these are: what exists, without
/// `options.force`; what is no pack, with it; a TARGET.part or TARGET.journal that no bake wrote; and the
/// work of an interrupted bake, unless it is to be resumed or `options.force` is set.
Status check_target(const BuildOptions& options);

}  // namespace cairn
