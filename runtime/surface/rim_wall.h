#pragma once

#include <cstdint>
#include <span>

#include "runtime/surface/mesh_plan.h"

namespace cairn::gl {

/// A vertex of a grid's rim, or above or below one.
struct RimVertex {
  std::int64_t along = 0;  ///< lattice units: longitude or latitude
  WallVertex vertex;
};

/// Joins two polylines over the same segment with triangles, so that each of their edges is the edge of one
/// triangle. At the segment's ends the way from one polyline to the other goes through every height of
/// `at_first` and `at_last` that lies between: other walls that end there have vertices at these.
///
/// REQUIRES: both polylines begin and end at the same places, in growing order; the heights are sorted.
void append_wall(std::span<const RimVertex> a, std::span<const RimVertex> b, std::span<const float> at_first,
                 std::span<const float> at_last, MeshPlan& plan);

}  // namespace cairn::gl
