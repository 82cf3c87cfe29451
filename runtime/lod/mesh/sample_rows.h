#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "cairn/height_tile.h"
#include "cairn/view_state.h"
#include "runtime/lod/mesh/grid_positions.h"

namespace cairn {

/// `count` consecutive samples of one row of a tile, from (column, row) to the east.
struct SampleRow {
  int column = 0;
  int row = 0;
  int count = 0;
};

/// Returns the rows that a convex polygon covers, its edges included, from the south.
/// Corners are (column, row), in order; `rows` is the memory for the result. REQUIRES: edges run along the
/// grid or diagonally, so that they meet each row in a sample; the polygon covers at most rows.size() rows.
std::span<const SampleRow> rows_of(std::span<const std::array<int, 2>> corners, std::span<SampleRow> rows);

/// A camera's axes, and its own position along them.
struct SampleCamera {
  explicit SampleCamera(const CameraFrame& frame);
  glm::dvec3 right, up, forward;
  glm::dvec3 position;
};

/// The viewport and the tolerance at depth 1; nearest_m is the least depth, in metres, of what is visible.
struct ViewportLimits {
  double half_width;
  double half_height;
  double nearest_m;
  double tolerance;
};

/// The plane of a flat triangle, in camera coordinates: at sample (column, row) it is at
/// at + column·by_column + row·by_row.
struct DrawnPlane {
  glm::dvec3 at;
  glm::dvec3 by_column;
  glm::dvec3 by_row;
};

/// Returns whether any visible sample's projection is farther than the tolerance from that of its place on
/// the plane, or has that place closer than nearest_m. REQUIRES: the horizon hides no sample.
bool any_sample_exceeds(std::span<const SampleRow> rows, const HeightTile& heights, double quantum_m,
                        const GridPositions& positions, const SampleCamera& camera, const DrawnPlane& plane,
                        const ViewportLimits& limits);

}  // namespace cairn
