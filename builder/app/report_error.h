#pragma once

#include "cairn/status.h"

namespace cairn {

/// Prints the error as the program's one line on stderr and returns the exit status that goes with it.
int report_error(const Error& error);

}  // namespace cairn
