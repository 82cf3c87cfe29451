#include "tests/support/drawn_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "cairn/geodesy.h"

namespace cairn::test {

using gl::GridPatch;

DrawnMesh::DrawnMesh(std::vector<gl::MeshArea> areas, gl::MeshPlan plan)
    : areas_(std::move(areas)), plan_(std::move(plan)) {
  for (std::size_t i = 0; i < plan_.patches.size(); ++i) patches_.emplace(plan_.patches[i].area, i);
}

DrawnMesh::Vertex DrawnMesh::vertex(const GridPatch& patch, int column, int row) const {
  column = std::min(column, patch.cells_east);
  row = std::min(row, patch.cells_north);
  const std::array<bool, 4> on_side = {row == 0, row == patch.cells_north, column == 0,
                                       column == patch.cells_east};
  const LatticePoint corner = south_west_of(patch.area);
  const std::int64_t step = lattice_width(patch.area.level + patch.cells_log2);
  std::size_t entry = patch.perimeter;
  for (unsigned side = 0; side < 4; ++side) {
    if ((patch.listed_sides >> side & 1) == 0) continue;
    if (on_side[side]) {
      const gl::PerimeterVertex& v =
          plan_.perimeter[entry + static_cast<std::size_t>(side < 2 ? column : row)];
      const LonLat place = place_of({corner.x + v.column * step, corner.y + v.row * step});
      const auto height = static_cast<double>(v.height_m);
      return {to_geocentric(place, std::isnan(height) ? 0 : height), std::isnan(height)};
    }
    entry += static_cast<std::size_t>(patch.cells()) + 1;
  }
  const LatticePoint point{corner.x + column * step, corner.y + row * step};
  const gl::MeshArea& area = areas_[patch.from];
  const auto surface = gl::ShownSurface::of(area.surface, area.detail);
  const double height = surface.tile ? static_cast<double>(gl::height_at(surface, point)) : 0;
  return {to_geocentric(place_of(point), std::isnan(height) ? 0 : height), std::isnan(height)};
}

/// Where the ellipsoid's normal at the place meets one of the two triangles of a cell.
std::optional<double> DrawnMesh::height_over(const GridPatch& patch, int column, int row,
                                             LonLat place) const {
  const Vertex sw = vertex(patch, column, row), se = vertex(patch, column + 1, row),
               ne = vertex(patch, column + 1, row + 1), nw = vertex(patch, column, row + 1);
  const glm::dvec3 foot = to_geocentric(place, 0), up = local_frame(place).up;
  for (const auto& [b, c] : {std::pair(se, ne), std::pair(ne, nw)}) {
    const glm::dvec3 u = b.position - sw.position, v = c.position - sw.position;
    const double determinant = glm::dot(glm::cross(u, v), up);
    if (std::abs(determinant) < 1e-9) continue;  // folded up
    const glm::dvec3 at = glm::inverse(glm::dmat3(u, v, -up)) * (foot - sw.position);
    if (at.x < -1e-9 || at.y < -1e-9 || at.x + at.y > 1 + 1e-9) continue;
    if (sw.is_void || b.is_void || c.is_void) return std::nullopt;
    return at.z;
  }
  return std::nullopt;
}

const GridPatch* DrawnMesh::patch_at(LonLat place) const {
  for (int level = kMaxLevel; level >= kMinLevel; --level) {
    const auto found = patches_.find(tile_at(place, level));
    if (found != patches_.end()) return &plan_.patches[found->second];
  }
  return nullptr;
}

std::array<int, 2> DrawnMesh::cell_at(const GridPatch& patch, LonLat place) {
  const GeoBounds b = tile_bounds(patch.area);
  return {static_cast<int>((place.lon - b.west) / b.width() * patch.cells()),
          static_cast<int>((place.lat - b.south) / b.height() * patch.cells())};
}

std::optional<double> DrawnMesh::height_m(LonLat place) const {
  const GridPatch* patch = patch_at(place);
  if (!patch) return std::nullopt;
  const auto [column, row] = cell_at(*patch, place);
  if (const auto height = height_over(*patch, column, row, place)) return height;
  // Beside a rim whose vertices were moved along it, or where a chord bends over the next cell.
  const auto near = [&](int i, int at, int other) {
    return std::abs(i - at) <= 1 || other <= 1 || other >= patch->cells() - 2;
  };
  for (int r = 0; r < patch->cells_north; ++r) {
    for (int c = 0; c < patch->cells_east; ++c) {
      if (!near(r, row, column) || !near(c, column, row)) continue;
      if (const auto height = height_over(*patch, c, r, place)) return height;
    }
  }
  return std::nullopt;
}

}  // namespace cairn::test
