#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <glm/vec3.hpp>

#include "cairn/height_tile.h"
#include "runtime/lod/mesh/grid_positions.h"
#include "cairn/view_state.h"

namespace cairn {

/// Samples of one row of a tile: `count` from (column, row) to the east.
struct SampleRow {
  int column = 0;
  int row = 0;
  int count = 0;
};

/// The rows that a convex part of a tile covers, its edges included: from the south. Corners are (column,
/// row), in order. REQUIRES: edges run along the grid or diagonally, so that they meet rows in samples; at
/// most `rows` of them.
std::span<const SampleRow> rows_of(std::span<const std::array<int, 2>> corners, std::span<SampleRow> rows);

/// A camera's axes, and where the eye is along them.
struct SampleCamera {
  explicit SampleCamera(const CameraFrame& frame);
  glm::dvec3 right, up, forward;
  glm::dvec3 eye;
};

/// A picture at depth 1.
struct PictureLimits {
  double half_width;
  double half_height;
  double nearest_m;
  double tolerance;
};

/// A flat triangle, in the camera, at the samples of a tile: at (column, row) it is
/// at + column·by_column + row·by_row.
struct DrawnPlane {
  glm::dvec3 at;
  glm::dvec3 by_column;
  glm::dvec3 by_row;
};

/// Whether any of the samples that is in the picture is off its place on the plane by more than the
/// tolerance, or has it beside or behind the eye. The horizon hides none.
bool any_is_off(std::span<const SampleRow> rows, const HeightTile& heights, double quantum_m,
                const GridPositions& positions, const SampleCamera& camera, const DrawnPlane& plane,
                const PictureLimits& limits);

}  // namespace cairn
