#include "runtime/surface/object_feet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "runtime/surface/patch_mesh.h"
#include "runtime/view/sample_lattice.h"

namespace cairn {
namespace {

constexpr double kPlaces = 65536;  // along a tile's side

class FootFinder {
 public:
  FootFinder(const SurfacePatch& patch, const SideVertices& sides, double quantum_m, const TileId& tile)
      : patch_(patch),
        triangulation_(patch, sides),
        vertices_(patch),
        quantum_m_(quantum_m),
        tile_(tile),
        corner_(south_west_of(patch.area)),
        per_cell_(1 / static_cast<double>(lattice_width(patch.area.level + patch.cells_log2))) {}

  ObjectFoot foot(const PlacedObject& object) const {
    ObjectFoot foot = ground(place_on_lattice(tile_, object));
    if (object.height_quanta != 0) foot.place += up_at(foot.place) * (object.height_quanta * quantum_m_);
    const double heading = glm::radians(object.heading_degrees());
    foot.heading = {static_cast<float>(std::sin(heading)), static_cast<float>(std::cos(heading))};
    return foot;
  }

 private:
  glm::dvec3 up_at(const glm::dvec3& place) const {
    const double a = patch_.ellipsoid.semi_major_m, b = patch_.ellipsoid.semi_minor_m;
    return glm::normalize(place / glm::dvec3(a * a, a * a, b * b));
  }

  ObjectFoot ground(const ObjectPlace& at) const {
    const double cells = patch_.cells();
    const double x = std::clamp((at.x - static_cast<double>(corner_.x)) * per_cell_, 0.0, cells);
    const double y = std::clamp((at.y - static_cast<double>(corner_.y)) * per_cell_, 0.0, cells);
    const PatchTriangulation::Triangle t = triangulation_.triangle_at(x, y);
    const std::array corners{t.from, t.to, t.apex};
    // Each corner's weight is the share of the area opposite to it.
    const double ax = t.to.column - t.from.column, ay = t.to.row - t.from.row;
    const double bx = t.apex.column - t.from.column, by = t.apex.row - t.from.row;
    const double px = x - t.from.column, py = y - t.from.row;
    const double area = ax * by - ay * bx;
    const double to = (px * by - py * bx) / area, apex = (ax * py - ay * px) / area;
    const std::array weights{1 - to - apex, to, apex};
    ObjectFoot foot;
    glm::dvec3 to_coarser{0};
    for (std::size_t i = 0; i < 3; ++i) {
      const SurfaceVertex vertex = vertices_.at(corners[i].column, corners[i].row).vertex;
      const glm::dvec3 place = glm::dvec3(vertex.high) + glm::dvec3(vertex.low);
      foot.place += place * weights[i];
      if (vertex.to_coarser_m != 0)
        to_coarser += up_at(place) * (static_cast<double>(vertex.to_coarser_m) * weights[i]);
    }
    foot.to_coarser = glm::vec3(to_coarser);
    return foot;
  }

  const SurfacePatch& patch_;
  PatchTriangulation triangulation_;
  PatchVertices vertices_;
  double quantum_m_;
  TileId tile_;
  LatticePoint corner_;
  double per_cell_;
};

}  // namespace

ObjectPlace place_on_lattice(const TileId& tile, const PlacedObject& object) {
  const LatticePoint corner = south_west_of(tile);
  const double width = static_cast<double>(lattice_width(tile.level));
  return {static_cast<double>(corner.x) + (object.x + 0.5) / kPlaces * width,
          static_cast<double>(corner.y) + (object.y + 0.5) / kPlaces * width};
}

std::vector<ObjectFoot> object_feet(const SurfacePatch& patch, const SideVertices& sides, double quantum_m,
                                    const TileId& tile, std::span<const StandingObject> objects) {
  const FootFinder finder(patch, sides, quantum_m, tile);
  std::vector<ObjectFoot> feet;
  feet.reserve(objects.size());
  for (const StandingObject& object : objects) feet.push_back(finder.foot(object.placed));
  return feet;
}

ObjectCluster cluster_of(std::span<const StandingObject> objects, std::span<const ObjectFoot> feet) {
  ObjectCluster cluster;
  glm::dvec3 low(std::numeric_limits<double>::max()), high(std::numeric_limits<double>::lowest());
  for (const ObjectFoot& foot : feet) {
    low = glm::min(low, foot.place);
    high = glm::max(high, foot.place);
  }
  if (!feet.empty()) cluster.middle = (low + high) * 0.5;
  for (std::size_t i = 0; i < feet.size(); ++i) {
    const double off = glm::length(feet[i].place - cluster.middle);
    cluster.radius_m =
        std::max(cluster.radius_m, static_cast<float>(off) + glm::length(feet[i].to_coarser) + 0.01F);
    cluster.largest_m = std::max(cluster.largest_m, objects[i].size_m);
  }
  return cluster;
}

}  // namespace cairn
