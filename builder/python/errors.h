#pragma once

#include <pybind11/pybind11.h>

#include "cairn/status.h"

namespace cairn {

/// Adds the exceptions Error, UsageError, BadDataError and Cancelled to the module.
void add_errors(pybind11::module_& module);

/// Raises the exception that stands for an error. Needs the GIL.
[[noreturn]] void raise(const Error& error);

/// Raises Cancelled. Needs the GIL.
[[noreturn]] void raise_cancelled(const std::string& message);

}  // namespace cairn
