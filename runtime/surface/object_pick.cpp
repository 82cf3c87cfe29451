#include "runtime/surface/object_pick.h"

#include <array>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace cairn {
namespace {

/// Where a ray meets a triangle, in lengths of the direction (Möller & Trumbore 1997); negative where it
/// does not.
double meet(const glm::dvec3& origin, const glm::dvec3& direction, const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 a = t[1] - t[0], b = t[2] - t[0], across = glm::cross(direction, b);
  const double det = glm::dot(a, across);
  if (det == 0) return -1;
  const glm::dvec3 from = origin - t[0];
  const double u = glm::dot(from, across) / det;
  const glm::dvec3 q = glm::cross(from, a);
  const double v = glm::dot(direction, q) / det;
  if (!(u >= 0 && v >= 0 && u + v <= 1)) return -1;
  return glm::dot(b, q) / det;
}

/// Of a model's finest level, the ray being in its axes and at scale 1.
double meet(const ObjectModel& model, const glm::dvec3& origin, const glm::dvec3& direction) {
  double nearest = std::numeric_limits<double>::infinity();
  if (model.levels.empty()) return nearest;
  const ModelLevel& level = model.levels.front();
  for (std::size_t k = level.first; k < std::size_t{level.first} + level.count; k += 3) {
    std::array<glm::dvec3, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) {
      const auto& p = model.vertices[model.indices[k + c]].position_m;
      corners[c] = {p[0], p[1], p[2]};
    }
    const double at = meet(origin, direction, corners);
    if (at >= 0 && at < nearest) nearest = at;
  }
  return nearest;
}

}  // namespace

std::optional<ObjectHit> pick_object(std::span<const ObjectPatch> patches, const Ellipsoid& ellipsoid,
                                     const glm::dvec3& origin, const glm::dvec3& direction) {
  const glm::dvec3 along = glm::normalize(direction);
  const double a = ellipsoid.semi_major_m, b = ellipsoid.semi_minor_m;
  std::optional<ObjectHit> hit;
  double nearest = std::numeric_limits<double>::infinity();
  for (const ObjectPatch& patch : patches) {
    for (std::size_t i = 0; i < patch.feet.size(); ++i) {
      const StandingObject& object = patch.standing[i];
      const ObjectFoot& foot = patch.feet[i];
      const glm::dvec3 place = foot.place + glm::dvec3(foot.to_coarser * patch.coarser_share);
      const glm::dvec3 to = place - origin;
      const auto reach = static_cast<double>(object.reach_m());
      if (glm::length(to - along * glm::dot(to, along)) > reach || glm::dot(to, along) - reach > nearest)
        continue;
      const glm::dvec3 up = glm::normalize(place / glm::dvec3(a * a, a * a, b * b));
      const glm::dvec3 east = glm::normalize(glm::dvec3(-up.y, up.x, 1e-9 * up.z));
      const glm::dvec3 north = glm::cross(up, east);
      const glm::dvec2 heading(foot.heading);
      const glm::dvec3 own_north = heading.x * east + heading.y * north;
      const glm::dvec3 own_east = heading.y * east - heading.x * north;
      const double scale = object.placed.scale_factor();
      const auto in_model = [&](const glm::dvec3& v) {
        return glm::dvec3(glm::dot(v, own_east), glm::dot(v, own_north), glm::dot(v, up)) / scale;
      };
      const auto& model = patch.objects->models()[object.slot];
      const double at = meet(*model, in_model(-to), in_model(along));
      if (at >= nearest) continue;
      nearest = at;
      hit = ObjectHit{patch.objects->tile(), object.placed, model, place, at};
    }
  }
  return hit;
}

}  // namespace cairn
