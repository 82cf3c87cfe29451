#pragma once

#include <vector>

#include "cairn/geo.h"
#include "cairn/status.h"

namespace cairn {

/// The bounds that `--region W,S,E,N` says; across the antimeridian where E is not above W. Wrong usage where
/// the four numbers are no area of the Earth.
Result<GeoBounds> region_of(const std::vector<double>& numbers);

}  // namespace cairn
