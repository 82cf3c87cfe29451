// Objects stand on the ground that is drawn, at every level of detail and while tiles are exchanged.

#include "runtime/surface/object_feet.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <random>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/surface/patch_mesh.h"
#include "runtime/surface/surface_plan.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

std::int32_t crags(std::int64_t column, std::int64_t row) {
  const auto mixed = static_cast<std::uint64_t>(column * 73856093 ^ row * 19349663);
  return static_cast<std::int32_t>(mixed % 997) + test::hills(column, row);
}

/// Tiles of one rough surface, each made once.
class Crags {
 public:
  const SurfaceTile* get(const TileId& id) {
    auto& slot = tiles_[id];
    if (!slot) {
      slot = std::make_unique<SurfaceTile>(
          prepare_surface_tile(id, std::make_shared<const HeightTile>(surface_.tile(id)), 0.25, false, {}));
    }
    return slot.get();
  }

 private:
  test::TestSurface surface_{257, 11, crags, {}};
  std::map<TileId, std::unique_ptr<SurfaceTile>> tiles_;
};

/// Objects of one model of no size; their heading is their number.
std::shared_ptr<const LoadedObjects> random_objects(const TileId& tile, std::size_t count,
                                                    std::mt19937& random) {
  ObjectTile objects;
  for (std::size_t i = 0; i < count; ++i) {
    PlacedObject object;
    object.x = static_cast<std::uint16_t>(random());
    object.y = static_cast<std::uint16_t>(random());
    if (i % 8 == 0) object.x = i % 16 == 0 ? 0 : 65535;
    if (i % 8 == 1) object.y = i % 16 == 1 ? 0 : 65535;
    object.heading = static_cast<std::uint16_t>(i);
    objects.objects.push_back(object);
  }
  const std::uint16_t number = 0;
  return std::make_shared<const LoadedObjects>(tile, objects, std::span(&number, 1),
                                               std::vector{std::make_shared<const ObjectModel>()});
}

/// The tile around a place and its neighbours, each with its own surface or an ancestor's, whole or on its
/// way to a coarser one.
std::vector<SurfaceArea> scene_around(const TileId& middle, std::mt19937& random, Crags& crags_of) {
  std::vector<SurfaceArea> areas;
  for (int step = 0; step < 9; ++step) {
    const TileId id = neighbour_of(middle, step % 3 - 1, step / 3 - 1);
    if (!is_valid(id)) continue;
    const int up = static_cast<int>(random() % 3);
    SurfaceArea area{id, crags_of.get(ancestor_of(id, id.level - up))};
    if (random() % 2 == 0) {
      area.detail = area.surface->id.level - static_cast<double>(random() % 12) / 4;
      area.moves = true;
    }
    areas.push_back(area);
  }
  return areas;
}

glm::dvec3 drawn_at(const SurfaceVertex& v, float coarser_share, const Ellipsoid& ellipsoid) {
  const glm::dvec3 at = glm::dvec3(v.high) + glm::dvec3(v.low);
  const double a = ellipsoid.semi_major_m, b = ellipsoid.semi_minor_m;
  const glm::dvec3 up = glm::normalize(at / glm::dvec3(a * a, a * a, b * b));
  return at + up * static_cast<double>(v.to_coarser_m * coarser_share);
}

/// The distance of a point from a triangle, in metres.
double distance_from(const glm::dvec3& p, const std::array<glm::dvec3, 3>& t) {
  const glm::dvec3 cross = glm::cross(t[1] - t[0], t[2] - t[0]);
  const double area = glm::length(cross);
  double nearest = 1e300;
  const auto to_edge = [&](const glm::dvec3& a, const glm::dvec3& b) {
    const double length2 = std::max(glm::dot(b - a, b - a), 1e-300);
    const double along = std::clamp(glm::dot(p - a, b - a) / length2, 0.0, 1.0);
    nearest = std::min(nearest, glm::distance(p, a + (b - a) * along));
  };
  for (std::size_t i = 0; i < 3; ++i) to_edge(t[i], t[(i + 1) % 3]);
  if (area == 0) return nearest;
  const glm::dvec3 normal = cross / area;
  for (std::size_t i = 0; i < 3; ++i) {
    if (glm::dot(glm::cross(t[(i + 1) % 3] - t[i], p - t[i]), normal) < 0) return nearest;
  }
  return std::min(nearest, std::abs(glm::dot(p - t[0], normal)));
}

double distance_from(const glm::dvec3& p, const PatchMesh& mesh, float coarser_share) {
  double nearest = 1e300;
  for (std::size_t k = 0; k < mesh.indices.size(); k += 3) {
    std::array<glm::dvec3, 3> corners;
    for (std::size_t c = 0; c < 3; ++c)
      corners[c] = drawn_at(mesh.vertices[mesh.indices[k + c]], coarser_share, {});
    nearest = std::min(nearest, distance_from(p, corners));
  }
  return nearest;
}

}  // namespace

TEST_CASE("at 1,000 cameras every foot is on a triangle that is drawn, under its object", "[slow]") {
  std::mt19937 random(19);
  Crags crags_of;
  const std::vector<TileId> middles = {tile_at({10.3, 45.7}, 4),     tile_at({179.9999, 3.2}, 5),
                                       tile_at({-179.9999, -60}, 3), tile_at({33, 89.999}, 2),
                                       tile_at({-70, -89.999}, 4),   tile_at({0.0001, 0.0001}, 6),
                                       tile_at({171, 86}, 0)};
  double worst_m = 0, worst_aside = 0;
  std::size_t feet = 0, gliding = 0;
  for (int camera = 0; camera < 1000; ++camera) {
    const TileId middle = middles[static_cast<std::size_t>(camera) % middles.size()];
    const std::vector<SurfaceArea> areas = scene_around(middle, random, crags_of);
    SurfaceRules rules;
    const GeoBounds bounds = tile_bounds(middle);
    const auto share = [&] { return static_cast<double>(random() % 1000) / 1000; };
    rules.view.eye = {bounds.west + bounds.width() * share(),
                      std::clamp(bounds.south + bounds.height() * share(), -90.0, 90.0)};
    rules.view.height_m = 1000 * std::pow(10.0, 3 * share());
    rules.view.heading_deg = 360 * share();
    rules.view.pitch_deg = -90 * share();
    rules.tolerance_px = 0.5 + 4 * share();
    rules.lowest_m = -1000;
    const SurfacePlan plan = plan_surface(areas, rules);
    for (std::size_t i = 0; i < plan.partition.patches.size(); ++i) {
      const SurfacePatch& patch = plan.partition.patches[i];
      const TileId tile = ancestor_of(patch.area, patch.area.level - static_cast<int>(random() % 3));
      const auto objects = random_objects(tile, 60, random);
      const std::span<const StandingObject> inside = objects->inside(patch.area);
      const std::vector<ObjectFoot> found = object_feet(patch, plan.joints.sides[i], 0.25, tile, inside);
      const PatchMesh mesh = build_patch_mesh(patch, plan.joints.sides[i]);
      const float coarser_share = patch.surface.coarser_share();
      for (std::size_t k = 0; k < std::min<std::size_t>(found.size(), 1); ++k) {
        const LonLat at = place_of(tile, inside[k].placed);
        const LocalFrame local = local_frame(at);
        const glm::dvec3 foot = found[k].place + glm::dvec3(found[k].to_coarser * coarser_share);
        worst_m = std::max(worst_m, distance_from(foot, mesh, coarser_share));
        // A flat triangle that stands for curved ground has its places a little aside.
        const glm::dvec3 under = to_geocentric(at, 0);
        const glm::dvec3 aside = foot - under - local.up * glm::dot(foot - under, local.up);
        const double cell_m = 111320 * tile_width_degrees(patch.area.level);
        worst_aside = std::max(worst_aside, glm::length(aside) / cell_m);
        gliding += found[k].to_coarser != glm::vec3(0) && coarser_share > 0;
        ++feet;
      }
    }
  }
  CAPTURE(feet, gliding);
  CHECK(feet > 15000);
  CHECK(gliding > 1000);
  CHECK(worst_m < 1e-4);  // metres
  CHECK(worst_aside < 0.01);
}

TEST_CASE("every object of a tile is in one of the areas that divide it, whatever they are") {
  std::mt19937 random(3);
  for (const TileId& tile : {tile_at({10.3, 45.7}, 2), TileId{-9, 0, 0}, tile_at({179.99, 89.99}, 1)}) {
    const auto objects = random_objects(tile, 5000, random);
    std::vector<std::uint32_t> seen(objects->all().size());
    // Areas of random depth all over the tile, and at an object's own place the finest there are.
    const ObjectPlace deep = place_on_lattice(tile, objects->all()[100].placed);
    std::vector<TileId> left{tile};
    while (!left.empty()) {
      const TileId area = left.back();
      left.pop_back();
      const LatticePoint corner = south_west_of(area);
      const auto width = static_cast<double>(lattice_width(area.level));
      const double x = deep.x - static_cast<double>(corner.x), y = deep.y - static_cast<double>(corner.y);
      const bool holds = x >= 0 && y >= 0 && x < width && y < width;
      const bool divides =
          (holds && area.level < kMaxLevel) || (area.level < tile.level + 7 && random() % 4 != 0);
      if (divides) {
        for (int quadrant = 0; quadrant < 4; ++quadrant) left.push_back(child_of(area, quadrant));
        continue;
      }
      for (const StandingObject& object : objects->inside(area)) {
        ++seen[object.placed.heading];
        const ObjectPlace at = place_on_lattice(tile, object.placed);
        CHECK((at.x >= static_cast<double>(corner.x) && at.x < static_cast<double>(corner.x) + width));
        CHECK((at.y >= static_cast<double>(corner.y) && at.y < static_cast<double>(corner.y) + width));
      }
    }
    CHECK(std::all_of(seen.begin(), seen.end(), [](std::uint32_t count) { return count == 1; }));
  }
}

}  // namespace cairn
