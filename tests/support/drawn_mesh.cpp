#include "tests/support/drawn_mesh.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <glm/geometric.hpp>
#include <glm/mat3x3.hpp>
#include <glm/matrix.hpp>

#include "cairn/geodesy.h"

namespace cairn::test {
namespace {

constexpr double kAside = 1 / 32.0;  // of a patch: so far chords bend over neighbouring triangles

glm::dvec3 position_of(const SurfaceVertex& vertex, float coarser_share, const glm::dvec3& up) {
  const double above = static_cast<double>(vertex.to_coarser_m) * static_cast<double>(coarser_share);
  return glm::dvec3(vertex.high) + glm::dvec3(vertex.low) + up * above;
}

/// Where the ellipsoid's normal at a place meets a triangle.
std::optional<double> height_over(const glm::dvec3 (&corners)[3], const glm::dvec3& foot,
                                  const glm::dvec3& up) {
  const glm::dvec3 u = corners[1] - corners[0], v = corners[2] - corners[0];
  const double determinant = glm::dot(glm::cross(u, v), up);
  if (std::abs(determinant) < 1e-9) return std::nullopt;
  const glm::dvec3 at = glm::inverse(glm::dmat3(u, v, -up)) * (foot - corners[0]);
  if (at.x < -1e-9 || at.y < -1e-9 || at.x + at.y > 1 + 1e-9) return std::nullopt;
  return at.z;
}

}  // namespace

DrawnMesh::DrawnMesh(std::vector<SurfaceArea> areas, SurfacePlan plan)
    : areas_(std::move(areas)), plan_(std::move(plan)) {
  const auto& patches = plan_.partition.patches;
  for (std::size_t i = 0; i < patches.size(); ++i) patches_.emplace(patches[i].area, i);
}

std::optional<std::size_t> DrawnMesh::patch_at(LonLat place) const {
  for (int level = kMaxLevel; level >= kMinLevel; --level) {
    const auto found = patches_.find(tile_at(place, level));
    if (found != patches_.end()) return found->second;
  }
  return std::nullopt;
}

const PatchMesh& DrawnMesh::mesh_of(std::size_t patch) const {
  const auto [at, fresh] = meshes_.try_emplace(patch);
  if (fresh) at->second = build_patch_mesh(plan_.partition.patches[patch], plan_.joints.sides[patch]);
  return at->second;
}

std::optional<double> DrawnMesh::height_m(LonLat place) const {
  const auto index = patch_at(place);
  if (!index) return std::nullopt;
  const std::vector<double> heights = heights_in(*index, place);
  return heights.empty() ? std::nullopt : std::optional(heights.front());
}

std::vector<double> DrawnMesh::heights_m(LonLat place) const {
  const auto index = patch_at(place);
  if (!index) return {};
  const double aside = tile_bounds(plan_.partition.patches[*index].area).height() * kAside;
  std::set<std::size_t> near;
  for (const int dy : {-1, 0, 1})
    for (const int dx : {-1, 0, 1})
      if (const auto beside = patch_at({place.lon + dx * aside, place.lat + dy * aside})) near.insert(*beside);
  std::vector<double> all;
  for (const std::size_t patch : near) {
    const std::vector<double> own = heights_in(patch, place);
    all.insert(all.end(), own.begin(), own.end());
  }
  return all;
}

std::vector<double> DrawnMesh::heights_in(std::size_t index, LonLat place) const {
  const SurfacePatch& patch = plan_.partition.patches[index];
  const PatchMesh& mesh = mesh_of(index);
  const GeoBounds b = tile_bounds(patch.area);
  const double east = std::remainder(place.lon - b.west, 360.0) / b.width() * kSurfaceSide;
  const double north = (place.lat - b.south) / b.height() * kSurfaceSide;
  const double aside = kSurfaceSide * kAside;
  const glm::dvec3 foot = to_geocentric(place, 0), up = local_frame(place).up;
  std::vector<double> heights;
  for (std::size_t k = 0; k < mesh.indices.size(); k += 3) {
    glm::dvec3 corners[3];
    double west = kSurfaceSide, last_east = 0, south = kSurfaceSide, last_north = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      const SurfaceVertex& v = mesh.vertices[mesh.indices[k + c]];
      west = std::min<double>(west, v.east);
      last_east = std::max<double>(last_east, v.east);
      south = std::min<double>(south, v.north);
      last_north = std::max<double>(last_north, v.north);
    }
    if (east < west - aside || east > last_east + aside || north < south - aside ||
        north > last_north + aside)
      continue;
    for (std::size_t c = 0; c < 3; ++c)
      corners[c] = position_of(mesh.vertices[mesh.indices[k + c]], patch.surface.coarser_share(), up);
    if (const auto height = height_over(corners, foot, up)) heights.push_back(*height);
  }
  return heights;
}

}  // namespace cairn::test
