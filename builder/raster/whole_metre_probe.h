#pragma once

#include "builder/raster/raster_source.h"

namespace cairn {

/// Returns whether a raster of a type that could hold fractions seems to hold whole metres only: the posts of
/// 25 windows all over it are whole, and at least eight of their heights differ, so that a sea around an
/// unseen island says nothing. A post that cannot be read says no.
bool seems_whole_metres(const RasterSource& raster);

}  // namespace cairn
