#include "runtime/lod/mesh/triangle_error.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace cairn {
namespace {

/// Of a triangle's width to its distance: below, its scale hardly changes over it, and the bound is as good.
constexpr double kFar = 1.0 / 32;

/// What is nearer along the view is treated as at the eye.
constexpr double kNearest_m = 1e-3;

/// Beyond the picture's sides, for what rounding moves over them.
constexpr double kMargin_px = 0.5;

/// > 0 where p is to the left of the line from a to b.
int left_of(const TriangleError::Corner& a, const TriangleError::Corner& b, int c, int r) {
  return (b[0] - a[0]) * (r - a[1]) - (b[1] - a[1]) * (c - a[0]);
}

}  // namespace

TriangleError::TriangleError(const ViewState& view)
    : camera_(camera_frame(view)),
      focal_px_(view.viewport_height_px / (2 * std::tan(glm::radians(view.fov_y_deg) / 2))),
      half_width_px_(view.viewport_width_px / 2.0 + kMargin_px),
      half_height_px_(view.viewport_height_px / 2.0 + kMargin_px) {}

glm::dvec3 TriangleError::in_camera(const glm::dvec3& point) const {
  const glm::dvec3 to = point - camera_.position;
  return {glm::dot(to, camera_.right), glm::dot(to, camera_.up), glm::dot(to, camera_.forward)};
}

bool TriangleError::exceeds(double most_px, const std::array<Corner, 3>& triangle, const HeightTile& heights,
                            double quantum_m, const GridPositions& positions) const {
  const auto& [a, b, c] = triangle;
  const auto at = [&](int column, int row) {
    return in_camera(positions.at(column, row, heights.at(column, row) * quantum_m));
  };
  const glm::dvec3 pa = at(a[0], a[1]);
  const glm::dvec3 pb = at(b[0], b[1]);
  if (glm::length(pb - pa) < kFar * glm::length(pa)) return true;
  const double scale = 1.0 / left_of(a, b, c[0], c[1]);
  const glm::dvec3 to_b = (pb - pa) * scale, to_c = (at(c[0], c[1]) - pa) * scale;
  const auto [low_row, high_row] = std::minmax({a[1], b[1], c[1]});
  const auto [low_column, high_column] = std::minmax({a[0], b[0], c[0]});
  const auto is_off = [&](int column, int row) {
    const int in_c = left_of(a, b, column, row), in_b = left_of(c, a, column, row);
    const glm::dvec3 is = at(column, row);
    if (is.z < kNearest_m || std::abs(is.x) * focal_px_ > half_width_px_ * is.z ||
        std::abs(is.y) * focal_px_ > half_height_px_ * is.z)
      return false;
    const glm::dvec3 drawn = pa + static_cast<double>(in_b) * to_b + static_cast<double>(in_c) * to_c;
    if (drawn.z < kNearest_m) return true;
    // Both over their depths; without dividing twice.
    const double du = drawn.x * is.z - is.x * drawn.z, dv = drawn.y * is.z - is.y * drawn.z;
    const double unit = most_px / focal_px_ * is.z * drawn.z;
    return du * du + dv * dv > unit * unit;
  };
  if (is_off((a[0] + b[0]) / 2, (a[1] + b[1]) / 2)) return true;
  // Every fourth first, then every second: what is off is mostly off over an area.
  for (int step = 4; step >= 1; step /= 2) {
    for (int row = low_row; row <= high_row; row += step) {
      for (int column = low_column; column <= high_column; column += step) {
        const bool was_looked_at = step < 4 && ((column - low_column) | (row - low_row)) % (2 * step) == 0;
        if (was_looked_at || left_of(a, b, column, row) < 0 || left_of(c, a, column, row) < 0 ||
            left_of(b, c, column, row) < 0)
          continue;
        if (is_off(column, row)) return true;
      }
    }
  }
  return false;
}

}  // namespace cairn
