#pragma once

#include <vector>

#include "builder/raster/raster_source.h"

namespace cairn {

/// Checks a raster's size and georeference, which come from bytes that nobody vouches for, and works out its
/// bounds; every format calls it before it hands a raster out. A CRS that cairn does not compute itself gets
/// its transform here (open_crs). bad_data where the raster is empty, its spacing is no number or zero, PROJ
/// does not know the CRS, a post lies beyond a pole or where the projection has no place.
///
/// Geographic rasters are tidied as well: decimals cut off in the file (0.000833333333 for 1/1200) are
/// restored where that moves no post by more than 1e-5 of the spacing, and whole turns are taken away so that
/// bounds.west lies in [-180, 180), give or take half a post.
Status place_raster(RasterInfo& info);

/// Rectangles of longitude and latitude that together hold all posts of a placed raster: one where its rim
/// runs along them, more where it is turned against them or holds a pole, so that they hold little else.
/// `halvings`: of the raster's sides, at most.
std::vector<GeoBounds> tight_bounds(const RasterInfo& info, int halvings);

/// Moves bounds by whole turns so that they lie as near to the others as they can.
void move_near(const GeoBounds& to, GeoBounds& moved);

}  // namespace cairn
