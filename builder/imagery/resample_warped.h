#pragma once

#include "builder/imagery/image_resample.h"

namespace cairn {

/// resample_image() of an image in a projection that bends the grid (UTM): in two dimensions, at positions
/// that a ProjectionMesh of the projection gives.
Result<ResampledImage> resample_warped(const RasterSource& source, const TexelWindow& window, double turn,
                                       bool with_rims);

}  // namespace cairn
