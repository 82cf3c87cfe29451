#pragma once

#include "builder/raster/raster_source.h"

namespace cairn {

/// Checks a raster's size and georeference, which come from bytes that nobody vouches for, and works out its
/// bounds; every format calls it before it hands a raster out. bad_data where the raster is empty, its
/// spacing is no number or zero, a post lies beyond a pole or where the projection has no place.
///
/// Geographic rasters are tidied as well: decimals cut off in the file (0.000833333333 for 1/1200) are
/// restored where that moves no post by more than 1e-5 of the spacing, and whole turns are taken away so that
/// bounds.west lies in [-180, 180), give or take half a post.
Status place_raster(RasterInfo& info);

}  // namespace cairn
