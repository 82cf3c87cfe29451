#pragma once

#include <pybind11/pybind11.h>

namespace cairn {

/// Adds the function bake() to the module.
void add_bake(pybind11::module_& module);

}  // namespace cairn
