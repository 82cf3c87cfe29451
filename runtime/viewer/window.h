#pragma once

#include <iosfwd>

#include "cairn/status.h"
#include "runtime/viewer/options.h"

namespace cairn::viewer {

/// Opens a window on the pack and flies until it is closed. failed where there is no display or no
/// OpenGL 4.5. What is damaged or missing goes to `messages`, a line each, and into the panel.
Status run_window(const Options& options, std::ostream& messages);

}  // namespace cairn::viewer
