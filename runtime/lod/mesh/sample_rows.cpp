#include "runtime/lod/mesh/sample_rows.h"

#include <algorithm>
#include <cassert>
#include <cstddef>
#include <limits>

#include <glm/geometric.hpp>

#include "format/simd_clones.h"

namespace cairn {

SampleCamera::SampleCamera(const CameraFrame& frame)
    : right(frame.right),
      up(frame.up),
      forward(frame.forward),
      position(glm::dot(frame.position, right), glm::dot(frame.position, up),
               glm::dot(frame.position, forward)) {}

std::span<const SampleRow> rows_of(std::span<const std::array<int, 2>> corners, std::span<SampleRow> rows) {
  int south = corners[0][1], north = south;
  for (const auto& [column, row] : corners) south = std::min(south, row), north = std::max(north, row);
  const auto count = static_cast<std::size_t>(north - south) + 1;
  assert(count <= rows.size());
  const auto found = rows.first(count);
  // Until all edges are known, `count` holds the last column.
  for (std::size_t i = 0; i < count; ++i)
    found[i] = {std::numeric_limits<int>::max(), south + static_cast<int>(i),
                std::numeric_limits<int>::min()};
  for (std::size_t k = 0; k < corners.size(); ++k) {
    std::array<int, 2> at = corners[k], to = corners[(k + 1) % corners.size()];
    if (at[1] == to[1]) continue;  // its ends belong to the adjacent edges too
    if (at[1] > to[1]) std::swap(at, to);
    const int step = (to[0] > at[0]) - (to[0] < at[0]);
    for (; at[1] <= to[1]; ++at[1], at[0] += step) {
      SampleRow& row = found[static_cast<std::size_t>(at[1] - south)];
      row.column = std::min(row.column, at[0]), row.count = std::max(row.count, at[0]);
    }
  }
  for (SampleRow& row : found) row.count -= row.column - 1;
  return found;
}

// The inner loop has no branch and no division, so that the compiler makes vectors of it. With P the sample
// and D its place on the plane, |D⊥/Dz − P⊥/Pz| > τ is tested as |D⊥Pz − P⊥Dz|² > (τDzPz)².
CAIRN_SIMD_CLONES bool any_sample_exceeds(std::span<const SampleRow> rows, const HeightTile& heights,
                                          double quantum_m, const GridPositions& positions,
                                          const SampleCamera& camera, const DrawnPlane& plane,
                                          const ViewportLimits& limits) {
  for (const SampleRow& row : rows) {
    __builtin_prefetch(
        &heights.samples[static_cast<std::size_t>(row.row) * static_cast<std::size_t>(heights.size) +
                         static_cast<std::size_t>(row.column)]);
  }
  for (const SampleRow& row : rows) {
    const auto column = static_cast<std::size_t>(row.column), line = static_cast<std::size_t>(row.row);
    const std::int32_t* quanta = &heights.samples[line * static_cast<std::size_t>(heights.size) + column];
    const GridPositions::Column* columns = &positions.columns()[column];
    const GridPositions::Row r = positions.rows()[line];
    const glm::dvec3 drawn = plane.at + static_cast<double>(row.column) * plane.by_column +
                             static_cast<double>(row.row) * plane.by_row;
    int exceeds = 0;
    for (int i = 0; i < row.count; ++i) {
      const double height = quanta[i] * quantum_m, across = (r.normal + height) * r.cosine;
      const double x = across * columns[i].cosine, y = across * columns[i].sine,
                   z = (r.polar_normal + height) * r.sine;
      const double px = x * camera.right.x + y * camera.right.y + z * camera.right.z - camera.position.x;
      const double py = x * camera.up.x + y * camera.up.y + z * camera.up.z - camera.position.y;
      const double pz =
          x * camera.forward.x + y * camera.forward.y + z * camera.forward.z - camera.position.z;
      const double dx = drawn.x + i * plane.by_column.x, dy = drawn.y + i * plane.by_column.y,
                   dz = drawn.z + i * plane.by_column.z;
      const double ex = dx * pz - px * dz, ey = dy * pz - py * dz, allowed = limits.tolerance * dz * pz;
      const int in_viewport = (pz > limits.nearest_m) & (px <= limits.half_width * pz) &
                              (-px <= limits.half_width * pz) & (py <= limits.half_height * pz) &
                              (-py <= limits.half_height * pz);
      exceeds |= in_viewport & ((ex * ex + ey * ey > allowed * allowed) | (dz < limits.nearest_m));
    }
    if (exceeds != 0) return true;
  }
  return false;
}

}  // namespace cairn
