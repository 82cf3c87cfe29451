#pragma once

#include "builder/objects/picture.h"
#include "cairn/object_model.h"

namespace cairn {

/// Draws the model's eight views into one square picture as ObjectModel says. `texture` is the model's own.
Picture draw_billboard(const ObjectModel& model, const Picture& texture);

}  // namespace cairn
