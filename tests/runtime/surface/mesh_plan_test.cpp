#include "runtime/surface/mesh_plan.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <random>
#include <set>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "runtime/surface/patch_partition.h"
#include "cairn/geodesy.h"
#include "tests/support/test_pack.h"

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
      *slot = {id, heights, 0.25, true, relief_of(*heights, 0.25)};
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

/// Shows each leaf with its own tile, an ancestor's, or nothing, and many with less detail than the tile has.
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
    MeshArea area{leaf, surface, std::max(0.0, glm::length(middle - eye) - b.width() * 80000)};
    if (surface && random() % 2 == 0) {
      const auto quarters = static_cast<double>(random() % (random() % 2 == 0 ? 6 : 36));
      area.detail = surface->id.level - quarters / 4;
      area.moves = random() % 2 == 0;
    }
    areas.push_back(area);
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

/// What terrain.vert draws for vertex k of a side.
Vertex drawn_vertex(const MeshPlan& plan, const GridPatch& patch, const MeshArea& area, unsigned side,
                    int k) {
  const int last = side < 2 ? patch.cells_east : patch.cells_north;
  if (patch.listed_sides >> side & 1) {
    std::size_t entry = patch.perimeter;
    for (unsigned s = 0; s < side; ++s) {
      if (patch.listed_sides >> s & 1) entry += static_cast<std::size_t>(patch.cells()) + 1;
    }
    return vertex_of(patch, plan.perimeter[entry + static_cast<std::size_t>(k)]);
  }
  const int moved = std::min(k, last);
  const int column = side < 2 ? moved : side == 2 ? 0 : patch.cells_east;
  const int row = side >= 2 ? moved : side == 0 ? 0 : patch.cells_north;
  const LatticePoint corner = south_west_of(patch.area);
  const std::int64_t step = lattice_width(patch.area.level + patch.cells_log2);
  const auto surface = ShownSurface::of(area.surface, area.detail);
  const float height = height_at(surface, {corner.x + column * step, corner.y + row * step});
  return vertex_of(patch, {static_cast<std::uint16_t>(column), static_cast<std::uint16_t>(row), height});
}

/// Counts an edge that is one, and none of a pole's, where all places are one.
void add_edge(Vertex a, Vertex b, EdgeCount& edges) {
  const bool pole = a.at.y == b.at.y && (a.at.y == 0 || a.at.y == kLatticePoleToPole);
  if (a == b || pole) return;
  if (b < a) std::swap(a, b);
  ++edges[{a, b}];
}

/// The edges of a patch's rim.
void add_rim(const MeshPlan& plan, const GridPatch& patch, const MeshArea& area, EdgeCount& edges) {
  for (unsigned side = 0; side < 4; ++side) {
    for (int k = 0; k < patch.cells(); ++k) {
      add_edge(drawn_vertex(plan, patch, area, side, k), drawn_vertex(plan, patch, area, side, k + 1), edges);
    }
  }
}

void add_walls(const MeshPlan& plan, EdgeCount& edges) {
  for (const auto& triangle : plan.wall_triangles) {
    std::array<Vertex, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) {
      const WallVertex& v = plan.wall_vertices.at(triangle[i]);
      corners[i] = vertex_of(plan.patches.at(v.patch), v.at);
    }
    for (std::size_t i = 0; i < 3; ++i) add_edge(corners[i], corners[(i + 1) % 3], edges);
  }
}

}  // namespace

TEST_CASE("grids and the walls between them are closed: their edges belong to two, to the last bit") {
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
      for (const GridPatch& patch : plan.patches) add_rim(plan, patch, areas[patch.from], edges);
      add_walls(plan, edges);
      // Where both rims of a wall have an edge, and where walls meet at an upright one, there are twice two.
      int unmatched = 0;
      for (const auto& [edge, count] : edges) unmatched += count % 2 != 0;
      CHECK(unmatched == 0);
      CHECK(plan.wall_triangles.size() > 100);
      CHECK(edges.size() > 100);
    }
  }
}

TEST_CASE("grids keep the tolerance, have a block's cells at most, and get coarser with distance") {
  Surfaces surfaces;
  const TileId id = tile_at({10.3, 45.7}, 3);
  const SurfaceTile* surface = surfaces.get(id);
  std::size_t previous = std::numeric_limits<std::size_t>::max();
  for (const double height : {1500.0, 20000.0, 300000.0, 5e6, 1e9}) {
    MeshRules rules;
    rules.tile_size = 257;
    rules.eye = to_geocentric({10.3, 45.7}, height);
    const std::vector<MeshArea> areas = {{id, surface, std::max(0.0, height - 2000)}};
    std::size_t cells = 0;
    for (const Patch& patch : partition_areas(areas, rules)) {
      const int cells_log2 = cells_log2_for_eye(patch, rules);
      REQUIRE(cells_log2 <= kBlockCellsLog2);
      const auto k = static_cast<std::size_t>(std::clamp(3 + 8 - patch.area.level - cells_log2, 0, 9));
      const auto error = static_cast<double>(surface->relief_under(patch.area).errors[k]);
      CHECK(error * rules.pixels_per_radian <= std::max(patch.distance_m, 0.01 * rules.pixels_per_radian));
      cells += std::size_t{1} << (2 * cells_log2);
    }
    CHECK(cells <= previous);
    CHECK(cells <= 256 * 256);
    previous = cells;
  }
  CHECK(previous == 1);
}

TEST_CASE("parts behind the picture's planes are left out, those before it are not") {
  Surfaces surfaces;
  const TileId id = tile_at({10.3, 45.7}, 3);
  MeshRules rules;
  rules.tile_size = 257;
  rules.eye = to_geocentric({10.31, 45.7}, 1500);
  const std::vector<MeshArea> areas = {{id, surfaces.get(id), 0}};
  const std::size_t all = partition_areas(areas, rules).size();
  rules.inward = {local_frame({10.31, 45.7}).north};
  const std::size_t northern = partition_areas(areas, rules).size();
  rules.inward = {-rules.inward[0]};
  const std::size_t southern = partition_areas(areas, rules).size();
  CHECK(northern < all);
  CHECK(southern < all);
  CHECK(northern + southern >= all);
}

TEST_CASE("decimation errors bound the distance to the decimated surface, and are exact for one step") {
  Surfaces surfaces;
  const HeightTile& tile = *surfaces.get(tile_at({-70.5, -33.1}, 4))->heights;
  const DecimationErrors errors = relief_of(tile, 0.25).whole.errors;
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

TEST_CASE(
    "a surface shown with less detail is its ancestor's at a whole level, and between two levels between "
    "them") {
  Surfaces surfaces;
  const TileId id = tile_at({10.3, 45.7}, 4);
  const SurfaceTile* tile = surfaces.get(id);
  const LatticePoint corner = south_west_of(id);
  std::mt19937 random(1);
  for (int i = 0; i < 5000; ++i) {
    const auto along = [&] {
      return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(lattice_width(4)));
    };
    const LatticePoint point{corner.x + along(), corner.y + along()};
    const int level = 4 - static_cast<int>(random() % 6);
    const auto shown = [&](double detail) {
      return static_cast<double>(height_at(ShownSurface::of(tile, detail), point));
    };
    const auto ancestor = static_cast<double>(height_at(*surfaces.get(ancestor_of(id, level)), point));
    REQUIRE(shown(level) == Approx(ancestor).margin(1e-3));
    REQUIRE(shown(level - 0.25) == Approx(0.75 * ancestor + 0.25 * shown(level - 1)).margin(1e-3));
  }
}

TEST_CASE("a height changes with detail without a jump, beside voids too") {
  const test::TestSurface holed{257, 4, rough, [](std::int64_t column, std::int64_t row) {
                                  return (column * 31 + row * 17) % 97 == 0 ||
                                         (column / 40 + row / 24) % 5 == 0;
                                }};
  const TileId id = tile_at({10.3, 45.7}, 4);
  const auto heights = std::make_shared<const HeightTile>(holed.tile(id));
  const SurfaceTile tile{id, heights, 0.25, true, {}};
  const LatticePoint corner = south_west_of(id);
  std::mt19937 random(2);
  int known = 0;
  for (int i = 0; i < 2000; ++i) {
    const auto along = [&] {
      return static_cast<std::int64_t>(random() % static_cast<std::uint64_t>(lattice_width(4)));
    };
    const LatticePoint point{corner.x + along(), corner.y + along()};
    if (std::isnan(height_at(tile, point))) continue;
    ++known;
    constexpr double kHair = 1e-6;
    for (int level = -3; level <= 4; ++level) {
      const auto shown = [&](double detail) {
        return static_cast<double>(height_at(ShownSurface::of(&tile, detail), point));
      };
      REQUIRE(shown(level - kHair) == Approx(shown(level)).margin(0.01));
      REQUIRE(shown(level + kHair) == Approx(shown(level)).margin(0.01));
    }
  }
  CHECK(known > 500);
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
