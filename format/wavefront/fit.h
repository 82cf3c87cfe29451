#pragma once

#include "format/wavefront/plane.h"

namespace cairn::wavefront {

/// The weights that predict this tile best: least squares over an eighth of its samples, each sample
/// counted the less the rougher the ground around it, so that a few cliffs don't rule the plains. Exact to
/// the bit on every CPU.
Weights fit_weights(const Geometry& g, const Plane& plane);

/// The same without wide instructions.
Weights fit_weights_portable(const Geometry& g, const Plane& plane);

}  // namespace cairn::wavefront
