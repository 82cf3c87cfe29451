#include "runtime/lod/mesh/sample_rows.h"

#include <algorithm>
#include <cassert>
#include <cstddef>

#include <glm/geometric.hpp>

#include "format/wide.h"

namespace cairn {
SampleCamera::SampleCamera(const CameraFrame& frame)
    : right(frame.right),
      up(frame.up),
      forward(frame.forward),
      eye(glm::dot(frame.position, right), glm::dot(frame.position, up), glm::dot(frame.position, forward)) {}

std::span<const SampleRow> rows_of(const std::array<std::array<int, 2>, 3>& triangle,
                                   std::span<SampleRow> rows) {
  const auto [south, north] = std::minmax({triangle[0][1], triangle[1][1], triangle[2][1]});
  const auto count = static_cast<std::size_t>(north - south) + 1;
  assert(count <= rows.size());
  for (std::size_t i = 0; i < count; ++i) {
    const int row = south + static_cast<int>(i);
    int first = std::max({triangle[0][0], triangle[1][0], triangle[2][0]}),
        last = std::min({triangle[0][0], triangle[1][0], triangle[2][0]});
    const auto include = [&](int column) { first = std::min(first, column), last = std::max(last, column); };
    for (std::size_t k = 0; k < 3; ++k) {
      const auto &a = triangle[k], &b = triangle[(k + 1) % 3];
      if (row < std::min(a[1], b[1]) || row > std::max(a[1], b[1])) continue;
      if (a[1] == b[1]) {
        include(a[0]);
        include(b[0]);
      } else {
        include(a[0] + (row - a[1]) * (b[0] - a[0]) / (b[1] - a[1]));
      }
    }
    rows[i] = {first, row, last - first + 1};
  }
  return rows.first(count);
}

// Inner loops without a branch or a division, so that they become vectors: with P the sample and D its place,
// |D⊥/Dz − P⊥/Pz| > τ is |D⊥Pz − P⊥Dz|² > (τDzPz)².
CAIRN_WIDE bool any_is_off(std::span<const SampleRow> rows, const HeightTile& heights, double quantum_m,
                           const GridPositions& positions, const SampleCamera& camera,
                           const DrawnPlane& plane, const PictureLimits& limits) {
  for (const SampleRow& row : rows) {
    const auto column = static_cast<std::size_t>(row.column), line = static_cast<std::size_t>(row.row);
    const std::int32_t* quanta = &heights.samples[line * static_cast<std::size_t>(heights.size) + column];
    const GridPositions::Column* columns = &positions.columns()[column];
    const GridPositions::Row r = positions.rows()[line];
    const glm::dvec3 drawn = plane.at + static_cast<double>(row.column) * plane.by_column +
                             static_cast<double>(row.row) * plane.by_row;
    int off = 0;
    for (int i = 0; i < row.count; ++i) {
      const double height = quanta[i] * quantum_m, across = (r.normal + height) * r.cosine;
      const double x = across * columns[i].cosine, y = across * columns[i].sine,
                   z = (r.polar_normal + height) * r.sine;
      const double px = x * camera.right.x + y * camera.right.y + z * camera.right.z - camera.eye.x;
      const double py = x * camera.up.x + y * camera.up.y + z * camera.up.z - camera.eye.y;
      const double pz = x * camera.forward.x + y * camera.forward.y + z * camera.forward.z - camera.eye.z;
      const double dx = drawn.x + i * plane.by_column.x, dy = drawn.y + i * plane.by_column.y,
                   dz = drawn.z + i * plane.by_column.z;
      const double ex = dx * pz - px * dz, ey = dy * pz - py * dz, allowed = limits.tolerance * dz * pz;
      const int is_seen = (pz > limits.nearest_m) & (px <= limits.half_width * pz) &
                          (-px <= limits.half_width * pz) & (py <= limits.half_height * pz) &
                          (-py <= limits.half_height * pz);
      off |= is_seen & ((ex * ex + ey * ey > allowed * allowed) | (dz < limits.nearest_m));
    }
    if (off != 0) return true;
  }
  return false;
}

}  // namespace cairn
