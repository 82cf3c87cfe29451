#pragma once

#include <functional>

#include "builder/objects/object_place.h"
#include "builder/objects/scatter_rule.h"
#include "cairn/body.h"
#include "cairn/geo.h"
#include "cairn/status.h"

namespace cairn {

/// Takes the scattered objects one by one. An error ends the scattering.
using TakeScattered = std::function<Status(const ObjectPlace&)>;

/// Scatters objects in the part of an area that is inside `bounds`.
///
/// They are a Poisson process on the whole body, thinned so that no two are nearer than the spacing (Matérn
/// 1960, type II), which depends on the density, the spacing and the seed only. So areas with the same
/// three fit together at a border, and the parts of several bounds are those of one. The limits of the
/// ground are left to the caller. The error is bad_data where more than 10^9 objects are expected. REQUIRES:
/// an area that check_area() accepts.
Status scatter(const ScatterArea& area, const Body& body, const GeoBounds& bounds, const TakeScattered& take);

}  // namespace cairn
