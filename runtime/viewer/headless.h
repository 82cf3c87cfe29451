#pragma once

#include <iosfwd>

#include "cairn/status.h"
#include "runtime/viewer/options.h"

namespace cairn::viewer {

/// Renders what the options ask for without a window. What is damaged or missing goes to `messages`, a line
/// each.
Status run_headless(const Options& options, std::ostream& messages);

}  // namespace cairn::viewer
