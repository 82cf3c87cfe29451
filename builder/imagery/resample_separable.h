#pragma once

#include "builder/imagery/image_resample.h"

namespace cairn {

/// resample_image() of an image whose columns depend on the longitude alone and its rows on the latitude
/// alone: one axis after the other.
Result<ResampledImage> resample_separable(const RasterSource& source, const TexelWindow& window, double turn,
                                          bool with_rims);

}  // namespace cairn
