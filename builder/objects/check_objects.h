#pragma once

#include "cairn/object_options.h"
#include "cairn/status.h"

namespace cairn {

/// Reads all places and the models that they name, and returns the first error: so that a bake ends with it
/// before it makes any tile.
Status check_objects(const ObjectOptions& options);

}  // namespace cairn
