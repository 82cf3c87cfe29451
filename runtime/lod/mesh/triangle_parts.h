#pragma once

#include "runtime/lod/mesh/triangle_samples.h"

namespace cairn {

/// Returns false only if no visible place of a larger triangle exceeds the tolerance, by a test of its parts.
///
/// Each part is held against the tolerance with its own range (subtriangles_over_tolerance()). Where few
/// parts of a small enough triangle may exceed, their samples are tested one by one. Where the triangle is so
/// large that the curvature's bound is coarse, its quarters are tested. REQUIRES: the triangle has ranges.
bool any_part_exceeds(const TriangleView& view, const TileSurface& surface, const CornerSamples& samples);

}  // namespace cairn
