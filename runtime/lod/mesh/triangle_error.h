#pragma once

#include <array>

#include <glm/vec3.hpp>

#include "format/height_tile.h"
#include "runtime/lod/mesh/grid_positions.h"
#include "runtime/view_state.h"

namespace cairn {

/// What a flat triangle between samples of a tile is off by on the picture, found by projecting them: the
/// measure of Screen, where a bound from afar (Allowance) is too careful.
class TriangleError {
 public:
  explicit TriangleError(const ViewState& view);

  /// (column, row) of the tile's samples.
  using Corner = std::array<int, 2>;

  /// Whether a sample that the triangle covers, its edges included, is in the picture and farther than
  /// `most_px` from its place on it, or the triangle is there not in front of the eye. A triangle that is far
  /// away for its size is not looked into: the answer is yes. The vertex that would bisect it is looked at
  /// first. REQUIRES: anticlockwise corners, the right angle last.
  bool exceeds(double most_px, const std::array<Corner, 3>& triangle, const HeightTile& heights,
               double quantum_m, const GridPositions& positions) const;

 private:
  glm::dvec3 in_camera(const glm::dvec3& point) const;

  CameraFrame camera_;
  double focal_px_;
  double half_width_px_;
  double half_height_px_;
};

}  // namespace cairn
