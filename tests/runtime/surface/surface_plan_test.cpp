#include "runtime/surface/surface_plan.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <memory>
#include <random>
#include <tuple>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "format/rqt_steps.h"
#include "runtime/surface/patch_mesh.h"
#include "runtime/surface/rim_walls.h"
#include "tests/support/test_pack.h"

namespace cairn {
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
      slot = std::make_unique<SurfaceTile>(
          prepare_surface_tile(id, std::make_shared<const HeightTile>(surface_.tile(id)), 0.25, false, {}));
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
std::vector<SurfaceArea> random_scene(const TileId& towards, std::mt19937& random, Surfaces& surfaces) {
  std::vector<TileId> leaves;
  split({kMinLevel, 0, 0}, towards, random, leaves);
  std::vector<SurfaceArea> areas;
  for (const TileId& leaf : leaves) {
    const SurfaceTile* surface = nullptr;
    const int up = static_cast<int>(random() % 14);
    if (up < 13)
      surface = surfaces.get(ancestor_of(leaf, std::max(kMinLevel, leaf.level - (up > 8 ? up : up % 3))));
    SurfaceArea area{leaf, surface};
    if (surface && random() % 2 == 0) {
      const auto quarters = static_cast<double>(random() % (random() % 2 == 0 ? 6 : 36));
      area.detail = surface->id.level - quarters / 4;
      area.moves = random() % 2 == 0;
    }
    areas.push_back(area);
  }
  return areas;
}

SurfaceRules rules_above(LonLat place, double height_m, double tolerance_px) {
  SurfaceRules rules;
  rules.view.eye = place;
  rules.view.height_m = height_m;
  rules.view.pitch_deg = -90;
  rules.tolerance_px = tolerance_px;
  rules.lowest_m = -1000;
  rules.cull = false;
  return rules;
}

/// All bits that decide where a vertex is drawn.
struct Vertex {
  std::array<std::uint32_t, 8> bits{};
  bool is_pole = false;
  auto operator<=>(const Vertex& o) const { return bits <=> o.bits; }
  bool operator==(const Vertex& o) const { return bits == o.bits; }
};
using EdgeCount = std::map<std::pair<Vertex, Vertex>, int>;

Vertex vertex_of(const SurfaceVertex& v, float coarser_share) {
  // A vertex that does not glide is the same whatever the share is.
  const float share = v.to_coarser_m == 0 ? 0 : coarser_share;
  Vertex out;
  out.is_pole = std::hypot(v.high.x, v.high.y) < 1e-3F;
  const std::array values = {v.high.x, v.high.y, v.high.z, v.low.x, v.low.y, v.low.z, v.to_coarser_m, share};
  for (std::size_t i = 0; i < values.size(); ++i)
    out.bits[i] = std::bit_cast<std::uint32_t>(values[i] + 0.0F);
  return out;
}

/// Counts an edge that is one, and none of a pole's, where all places are one.
void add_edge(Vertex a, Vertex b, EdgeCount& edges) {
  if (a == b || (a.is_pole && b.is_pole)) return;
  if (b < a) std::swap(a, b);
  ++edges[{a, b}];
}

bool are_on_one_side(const SurfaceVertex& a, const SurfaceVertex& b) {
  const auto on = [](std::uint16_t u, std::uint16_t v) { return u == v && (u == 0 || u == kSurfaceSide); };
  return on(a.east, b.east) || on(a.north, b.north);
}

/// The edges of a patch's rim; those within a triangulation meet by the way that it is made.
void add_rim(const SurfacePatch& patch, const SideVertices& sides, EdgeCount& edges) {
  const PatchMesh mesh = build_patch_mesh(patch, sides);
  const float share = patch.surface.coarser_share();
  for (std::size_t k = 0; k < mesh.indices.size(); k += 3) {
    for (std::size_t c = 0; c < 3; ++c) {
      const SurfaceVertex& a = mesh.vertices[mesh.indices[k + c]];
      const SurfaceVertex& b = mesh.vertices[mesh.indices[k + (c + 1) % 3]];
      if (are_on_one_side(a, b)) add_edge(vertex_of(a, share), vertex_of(b, share), edges);
    }
  }
}

void add_walls(const SurfacePlan& plan, const SurfaceWalls& walls, EdgeCount& edges) {
  for (std::size_t k = 0; k < walls.indices.size(); k += 3) {
    std::array<Vertex, 3> corners;
    for (std::size_t c = 0; c < 3; ++c) {
      const SurfaceWallVertex& v = walls.vertices.at(walls.indices[k + c]);
      corners[c] = vertex_of(v.vertex, plan.partition.patches.at(v.patch).surface.coarser_share());
    }
    for (std::size_t c = 0; c < 3; ++c) add_edge(corners[c], corners[(c + 1) % 3], edges);
  }
}

}  // namespace

TEST_CASE("patches and the walls between them are closed: their edges belong to two, to the last bit",
          "[slow]") {
  std::mt19937 random(7);
  Surfaces surfaces;
  const std::vector<TileId> eyes = {tile_at({10.3, 45.7}, 9),     tile_at({179.9999, 3.2}, 11),
                                    tile_at({-179.9999, -60}, 8), tile_at({33, 89.999}, 7),
                                    tile_at({-70, -89.999}, 6),   tile_at({0.0001, 0.0001}, 10),
                                    tile_at({171, 86}, 4),        tile_at({-100, 40}, 2)};
  for (const TileId& eye : eyes) {
    for (const double tolerance : {0.3, 4.0, 60.0}) {
      CAPTURE(to_string(eye), tolerance);
      const std::vector<SurfaceArea> areas = random_scene(eye, random, surfaces);
      const SurfacePlan plan =
          plan_surface(areas, rules_above({tile_bounds(eye).west, tile_bounds(eye).south}, 3000, tolerance));
      REQUIRE(plan.partition.patches.size() >= areas.size());
      EdgeCount edges;
      for (std::size_t i = 0; i < plan.partition.patches.size(); ++i)
        add_rim(plan.partition.patches[i], plan.joints.sides[i], edges);
      SurfaceWalls walls;
      append_walls(plan.partition, plan.joints, walls);
      add_walls(plan, walls, edges);
      // Where both rims of a wall have an edge, and where walls meet at an upright one, there are twice two.
      int unmatched = 0;
      for (const auto& [edge, count] : edges) unmatched += count % 2 != 0;
      CHECK(unmatched == 0);
      CHECK(walls.indices.size() > 300);
      CHECK(edges.size() > 100);
    }
  }
}

TEST_CASE("each triangulation of a tile is closed under its needs, and keeps its tolerance at every sample") {
  Surfaces surfaces;
  const SurfaceTile& tile = *surfaces.get(tile_at({10.3, 45.7}, 3));
  const int size = tile.heights->size;
  for (const double tolerance_m : {0.01, 5.0, 60.0, 300.0}) {
    const int step = VertexSteps::step_within(tolerance_m);
    CHECK(VertexSteps::tolerance_m(step) <= tolerance_m);
    CHECK(VertexSteps::tolerance_m(step + 1) > tolerance_m);
    SurfacePatch patch{tile_at({10.3, 45.7}, 5), 0, ShownSurface::of(&tile, 3), 6, step, 0};
    REQUIRE(patch.sample_cells_log2() == 6);
    const PatchMesh mesh = build_patch_mesh(patch, {});
    const int deeper = 2, column = (patch.area.x - (tile.id.x << deeper)) * 64,
              row = (patch.area.y - (tile.id.y << deeper)) * 64;
    double worst = 0;
    std::size_t covered = 0;
    for (std::size_t k = 0; k < mesh.indices.size(); k += 3) {
      std::array<std::array<int, 2>, 3> at{};
      std::array<double, 3> height{};
      for (std::size_t c = 0; c < 3; ++c) {
        const SurfaceVertex& v = mesh.vertices[mesh.indices[k + c]];
        at[c] = {v.east * 64 / kSurfaceSide, v.north * 64 / kSurfaceSide};
        height[c] = static_cast<double>(v.height_m);
        CHECK(height[c] == tile.heights->at(column + at[c][0], row + at[c][1]) * 0.25);
      }
      const auto cross = [&](int c, int r, std::size_t i, std::size_t j) {
        return (at[i][0] - c) * (at[j][1] - r) - (at[j][0] - c) * (at[i][1] - r);
      };
      const int area = cross(at[2][0], at[2][1], 0, 1);
      REQUIRE(area > 0);
      for (int r = 0; r <= 64; ++r) {
        for (int c = 0; c <= 64; ++c) {
          const int a = cross(c, r, 1, 2), b = cross(c, r, 2, 0), d = cross(c, r, 0, 1);
          if (a < 0 || b < 0 || d < 0) continue;
          ++covered;
          const double drawn = (height[0] * a + height[1] * b + height[2] * d) / area;
          worst = std::max(worst, std::abs(drawn - tile.heights->at(column + c, row + r) * 0.25));
        }
      }
    }
    CAPTURE(tolerance_m, mesh.indices.size() / 3);
    CHECK(covered >= 65 * 65);
    CHECK(worst <= tolerance_m);
    for (int r = 0; r < size; ++r) {
      for (int c = 0; c < size; ++c) {
        const bool corner = (r == 0 || r == size - 1) && (c == 0 || c == size - 1);
        if (corner || !tile.steps.has(c, r, step)) continue;
        const RqtNeeds needs = rqt_needs_of(c, r, size, root_rises(tile.id));
        for (const std::size_t need : {needs.first, needs.second}) {
          const int nc = static_cast<int>(need % static_cast<std::size_t>(size));
          const int nr = static_cast<int>(need / static_cast<std::size_t>(size));
          const bool need_is_corner = (nr == 0 || nr == size - 1) && (nc == 0 || nc == size - 1);
          if (!need_is_corner && !tile.steps.has(nc, nr, step)) FAIL("a vertex without what it needs");
        }
      }
    }
  }
}

TEST_CASE("fewer triangles are drawn from farther away") {
  Surfaces surfaces;
  const TileId id = tile_at({10.3, 45.7}, 3);
  const std::vector<SurfaceArea> areas = {{id, surfaces.get(id)}};
  std::size_t previous = 3 * 256 * 256;
  for (const double height : {1500.0, 20000.0, 300000.0, 5e6, 1e9}) {
    SurfaceMesher mesher(2);
    const std::size_t triangles = mesher.frame(areas, rules_above({10.3, 45.7}, height, 1)).triangles;
    CHECK(triangles <= previous);
    previous = triangles;
  }
  CHECK(previous == 2 * 16);
}

TEST_CASE("a frame makes what is new, in ranges of its own, and nothing while the eye rests") {
  Surfaces surfaces;
  const TileId id = tile_at({10.3, 45.7}, 3);
  const std::vector<SurfaceArea> areas = {{id, surfaces.get(id)}};
  SurfaceMesher mesher(2);
  CHECK(!mesher.frame(areas, rules_above({10.3, 45.7}, 9000, 1)).uploads.empty());
  CHECK(mesher.frame(areas, rules_above({10.3, 45.7}, 9000, 1)).uploads.empty());
  std::uint32_t largest = 0;
  for (int i = 0; i < 500; ++i) {
    const SurfaceMesh mesh = mesher.frame(areas, rules_above({10.3, 45.7}, 9000 + 400 * i, 1));
    std::map<std::uint32_t, std::uint32_t> ranges;
    for (const SurfaceDraw& draw : mesh.draws) ranges.emplace(draw.first_index, draw.index_count);
    CHECK(ranges.size() == mesh.draws.size());
    std::uint32_t end = 0;
    for (const auto& [first, count] : ranges) {
      CHECK(first >= end);
      end = first + count;
    }
    CHECK(end <= mesh.index_end);
    largest = std::max(largest, mesh.index_end);
  }
  CHECK(largest < 100 * 3 * 2 * 256 * 256);
}

TEST_CASE("parts behind the picture's sides are left out, those before it are not") {
  Surfaces surfaces;
  const TileId id = tile_at({10.3, 45.7}, 3);
  const std::vector<SurfaceArea> areas = {{id, surfaces.get(id)}};
  SurfaceRules rules = rules_above({10.31, 45.7}, 1500, 1);
  rules.view.pitch_deg = -10;
  const std::size_t all = partition_areas(areas, rules).patches.size();
  rules.cull = true;
  const std::size_t northern = partition_areas(areas, rules).patches.size();
  rules.view.heading_deg = 180;
  const std::size_t southern = partition_areas(areas, rules).patches.size();
  CHECK(northern < all);
  CHECK(southern < all);
  CHECK(northern > 10);
}

TEST_CASE("decimation errors bound the distance to the decimated surface, and are exact for one step") {
  Surfaces surfaces;
  const TileId id = tile_at({-70.5, -33.1}, 4);
  const HeightTile& tile = *surfaces.get(id)->heights;
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
        const bool rises = diagonal_rises(root_rises(id), tile.size, c0, r0, step);
        const double drawn =
            rises        ? (u >= v ? sw + (se - sw) * u + (ne - se) * v : sw + (ne - nw) * u + (nw - sw) * v)
            : u + v <= 1 ? sw + (se - sw) * u + (nw - sw) * v
                         : ne + (nw - ne) * (1 - u) + (se - ne) * (1 - v);
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
  const SurfaceTile tile = prepare_surface_tile(id, heights, 0.25, false, {});
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

}  // namespace cairn
