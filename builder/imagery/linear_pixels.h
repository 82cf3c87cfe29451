#pragma once

#include <cstdint>
#include <span>

#include "builder/imagery/texel_loops.h"
#include "builder/raster/raster_source.h"
#include "builder/resample/projection_mesh.h"

namespace cairn {

/// RGBA pixels (4 bytes each, from `rgba` on) in linear light, times their alpha.
void to_linear_light(const std::uint8_t* rgba, std::span<FloatTexel> pixels);

/// Pixels from a position (column, row; 0 is the first pixel's centre) to the image's rim, below 0 outside.
double rim_distance(const RasterInfo& info, PlanePoint position);

}  // namespace cairn
