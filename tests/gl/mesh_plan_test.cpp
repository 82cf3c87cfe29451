#include "runtime/gl/mesh_plan.h"

#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "runtime/geodesy.h"
#include "tests/test_pack.h"

namespace cairn::gl {
namespace {

std::int32_t rough(std::int64_t column, std::int64_t row) {
  const auto mixed = static_cast<std::uint64_t>(column * 73856093 ^ row * 19349663);
  return static_cast<std::int32_t>(mixed % 997) + test::hills(column, row);
}

/// Tiles of one rough surface, each made once.
class Surfaces {
 public:
  const SurfaceTile* get(const TileId& id) {
    auto& slot = tiles_[id];
    if (!slot) {
      const auto heights = std::make_shared<const HeightTile>(surface_.tile(id));
      slot = std::make_unique<SurfaceTile>();
      *slot = {id, heights, 0.25, 0, 2000, decimation_errors(*heights, 0.25)};
    }
    return slot.get();
  }

 private:
  test::TestSurface surface_{257, 11, rough, {}};
  std::map<TileId, std::unique_ptr<SurfaceTile>> tiles_;
};

/// Splits around a place, and at random, until `deepest`.
void split(const TileId& id, const TileId& towards, std::mt19937& random, std::vector<TileId>& leaves) {
  if (!is_valid(id)) return;
  const bool holds = id.level < towards.level && ancestor_of(towards, id.level) == id;
  if (holds || (id.level < -5 && random() % 3 == 0)) {
    for (int q = 0; q < 4; ++q) split(child_of(id, q), towards, random, leaves);
    return;
  }
  leaves.push_back(id);
}

/// Shows each leaf with its own tile, an ancestor's, or nothing.
std::vector<MeshArea> random_scene(const TileId& towards, std::mt19937& random, Surfaces& surfaces) {
  std::vector<TileId> leaves;
  split({kMinLevel, 0, 0}, towards, random, leaves);
  const glm::dvec3 eye = to_geocentric({tile_bounds(towards).west, tile_bounds(towards).south}, 3000);
  std::vector<MeshArea> areas;
  for (const TileId& leaf : leaves) {
    const SurfaceTile* surface = nullptr;
    const int up = static_cast<int>(random() % 14);
    if (up < 13)
      surface = surfaces.get(ancestor_of(leaf, std::max(kMinLevel, leaf.level - (up > 8 ? up : up % 3))));
    const GeoBounds b = tile_bounds(leaf);
    const glm::dvec3 middle =
        to_geocentric({(b.west + b.east) / 2, std::min(90.0, (b.south + b.north) / 2)}, 0);
    areas.push_back({leaf, surface, std::max(0.0, glm::length(middle - eye) - b.width() * 80000)});
  }
  return areas;
}

struct Vertex {
  LatticePoint at;
  std::uint32_t height_bits = 0;
  auto key() const { return std::tuple(at.x, at.y, height_bits); }
  bool operator<(const Vertex& o) const { return key() < o.key(); }
  bool operator==(const Vertex& o) const { return key() == o.key(); }
};
using EdgeCount = std::map<std::pair<Vertex, Vertex>, int>;

Vertex vertex_of(const GridPatch& patch, const PerimeterVertex& v) {
  const std::int64_t step = lattice_width(patch.area.level + patch.cells_log2);
  const LatticePoint corner = south_west_of(patch.area);
  LatticePoint at{corner.x + v.column * step, corner.y + v.row * step};
  REQUIRE(at.x <= kLatticeAround);
  REQUIRE(at.y <= kLatticePoleToPole);
  if (at.x == kLatticeAround) at.x = 0;
  return {at, std::bit_cast<std::uint32_t>(v.height_m)};
}

/// Counts the edges of a patch's rim, without those along a pole.
void add_rim(const MeshPlan& plan, const GridPatch& patch, EdgeCount& edges) {
  const auto side = static_cast<std::size_t>(patch.cells()) + 1;
  for (std::size_t s = 0; s < 4; ++s) {
    for (std::size_t k = 0; k + 1 < side; ++k) {
      const auto* v = &plan.perimeter[patch.perimeter + s * side + k];
      Vertex a = vertex_of(patch, v[0]), b = vertex_of(patch, v[1]);
      if (a == b) continue;
      const bool pole = a.at.y == b.at.y && (a.at.y == 0 || a.at.y == kLatticePoleToPole);
      if (pole) continue;
      if (b < a) std::swap(a, b);
      ++edges[{a, b}];
    }
  }
}

}  // namespace

TEST_CASE("every edge of every grid's rim is an edge of one other grid's rim, to the last bit") {
  std::mt19937 random(7);
  Surfaces surfaces;
  const std::vector<TileId> eyes = {tile_at({10.3, 45.7}, 9),     tile_at({179.9999, 3.2}, 11),
                                    tile_at({-179.9999, -60}, 8), tile_at({33, 89.999}, 7),
                                    tile_at({-70, -89.999}, 6),   tile_at({0.0001, 0.0001}, 10),
                                    tile_at({171, 86}, 4),        tile_at({-100, 40}, 2)};
  for (const TileId& eye : eyes) {
    for (const double tolerance : {0.3, 4.0, 60.0}) {
      CAPTURE(to_string(eye), tolerance);
      const std::vector<MeshArea> areas = random_scene(eye, random, surfaces);
      MeshRules rules;
      rules.tile_size = 257;
      rules.tolerance_px = tolerance;
      rules.eye = to_geocentric({tile_bounds(eye).west, tile_bounds(eye).south}, 3000);
      const MeshPlan plan = plan_mesh(areas, rules);
      REQUIRE(plan.patches.size() >= areas.size());
      EdgeCount edges;
      for (const GridPatch& patch : plan.patches) add_rim(plan, patch, edges);
      int unmatched = 0;
      for (const auto& [edge, count] : edges) unmatched += count != 2;
      CHECK(unmatched == 0);
      CHECK(edges.size() > 100);
    }
  }
}

TEST_CASE("a grid is as coarse as the tolerance allows, and no coarser") {
  Surfaces surfaces;
  const TileId id = tile_at({10.3, 45.7}, 3);
  const SurfaceTile* surface = surfaces.get(id);
  int previous = 9;
  for (const double distance : {0.0, 1000.0, 30000.0, 1e6, 1e8}) {
    const std::vector<MeshArea> areas = {{id, surface, distance}};
    MeshRules rules;
    rules.tile_size = 257;
    rules.eye = to_geocentric({10.3, 45.7}, 5000);
    const MeshPlan plan = plan_mesh(areas, rules);
    REQUIRE(plan.patches.size() == 1);
    const int cells_log2 = plan.patches[0].cells_log2;
    CHECK(cells_log2 <= previous);
    const auto error = static_cast<double>(surface->errors[static_cast<std::size_t>(8 - cells_log2)]);
    if (cells_log2 < 8) CHECK(error * rules.pixels_per_radian <= distance);
    previous = cells_log2;
  }
  CHECK(previous == 0);
}

TEST_CASE("decimation errors bound the distance to the decimated surface, and are exact for one step") {
  Surfaces surfaces;
  const HeightTile& tile = *surfaces.get(tile_at({-70.5, -33.1}, 4))->heights;
  const DecimationErrors errors = decimation_errors(tile, 0.25);
  CHECK(errors[0] == 0);
  for (int k = 1; k <= 8; ++k) {
    const int step = 1 << k;
    double worst = 0;
    for (int r = 0; r < tile.size; ++r) {
      for (int c = 0; c < tile.size; ++c) {
        const int c0 = std::min(c / step * step, tile.size - 1 - step);
        const int r0 = std::min(r / step * step, tile.size - 1 - step);
        const double u = static_cast<double>(c - c0) / step, v = static_cast<double>(r - r0) / step;
        const double sw = tile.at(c0, r0), se = tile.at(c0 + step, r0), nw = tile.at(c0, r0 + step),
                     ne = tile.at(c0 + step, r0 + step);
        const double drawn = u >= v ? sw + (se - sw) * u + (ne - se) * v : sw + (ne - nw) * u + (nw - sw) * v;
        worst = std::max(worst, std::abs(drawn - tile.at(c, r)) * 0.25);
      }
    }
    CAPTURE(k);
    CHECK(worst <= static_cast<double>(errors[static_cast<std::size_t>(k)]) * (1 + 1e-6));
    if (k == 1) CHECK(worst == Approx(errors[1]));
  }
}

TEST_CASE("a height between samples is the same from both tiles that share the edge") {
  Surfaces surfaces;
  const TileId west = tile_at({10.3, 45.7}, 2);
  const SurfaceTile* a = surfaces.get(west);
  const SurfaceTile* b = surfaces.get(neighbour_of(west, 1, 0));
  const LatticePoint corner = south_west_of(b->id);
  for (std::int64_t i = 0; i < 5000; ++i) {
    const LatticePoint p{corner.x, corner.y + i * lattice_width(2) / 5000};
    REQUIRE(height_at(*a, p) == height_at(*b, p));
  }
}

}  // namespace cairn::gl
