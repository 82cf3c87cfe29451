// A thinned mesh held against every sample that its triangles cover, and against the mesh that it was.

#include "runtime/lod/mesh/vertex_decimation.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>
#include <set>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>

#include "cairn/geodesy.h"
#include "runtime/lab/watertight.h"
#include "runtime/lod/mesh/screen.h"
#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

constexpr int kSize = 65;
constexpr double kQuantum_m = 0.25;

/// Hills, and a step across the grid.
HeightTile stepped(const TileId& id, int relief) {
  HeightTile heights;
  heights.size = kSize;
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column) {
      const std::int32_t step = 5 * column + 3 * row > 250 ? 400 : 0;
      heights.samples.push_back(step +
                                relief * hills(id.x * (kSize - 1) + column, id.y * (kSize - 1) + row) / 16);
    }
  }
  return heights;
}

/// One area, a quarter of its source where that is `deeper`.
LodScene scene_of(const TileId& source, bool deeper, int relief) {
  LodTile tile;
  tile.source = tile.area = source;
  if (deeper) tile.area = {source.level + 1, 2 * source.x + 1, 2 * source.y};
  auto heights = std::make_shared<HeightTile>(stepped(source, relief));
  const auto [low, high] = std::minmax_element(heights->samples.begin(), heights->samples.end());
  tile.min_m = *low * kQuantum_m, tile.max_m = *high * kQuantum_m;
  tile.heights = heights;
  return {kSize, kQuantum_m, tile.min_m, {tile}};
}

/// All samples, each cell in two; of a square of cells, nothing is left.
LodMesh grid_of(const TileWindow& window, int hole) {
  LodTileMesh tile{0, {}, {}};
  const int n = window.cells();
  for (int r = 0; r <= n; ++r) {
    for (int c = 0; c <= n; ++c) tile.vertices.push_back(window.vertex(c, r));
  }
  for (int r = 0; r < n; ++r) {
    for (int c = 0; c < n; ++c) {
      if (c >= 5 && c < 5 + hole && r >= 7 && r < 7 + hole) continue;
      const auto at = static_cast<std::uint32_t>(r * (n + 1) + c),
                 up = at + static_cast<std::uint32_t>(n) + 1;
      tile.triangles.push_back({at, at + 1, up + 1});
      tile.triangles.push_back({at, up + 1, up});
    }
  }
  LodMesh mesh;
  mesh.tiles.push_back(std::move(tile));
  return mesh;
}

using Corner = std::array<int, 2>;

Corner corner_of(const TileWindow& window, const LodVertex& v) {
  const LatticePoint origin = window.point(0, 0);
  return {static_cast<int>((v.point.x - origin.x) / window.spacing()),
          static_cast<int>((v.point.y - origin.y) / window.spacing())};
}

int area(const Corner& a, const Corner& b, const Corner& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Returns the edges that have a triangle on one side only.
std::set<std::array<Corner, 2>> rim(const TileWindow& window, const LodTileMesh& mesh) {
  std::set<std::array<Corner, 2>> edges;
  for (const LodTriangle& t : mesh.triangles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Corner from = corner_of(window, mesh.vertices[t[i]]),
                   to = corner_of(window, mesh.vertices[t[(i + 1) % 3]]);
      if (edges.erase({to, from}) == 0) edges.insert({from, to});
    }
  }
  return edges;
}

/// Returns the largest screen error of samples in the viewport.
double most_off_px(const TileWindow& window, const LodTileMesh& mesh, const ViewState& view) {
  const CameraFrame camera = camera_frame(view);
  const double focal = view.viewport_height_px / 2.0 / std::tan(glm::radians(view.fov_y_deg / 2));
  const auto place = [&](const Corner& at) {
    return camera.in_camera(to_geocentric(window.point(at[0], at[1]), window.height_m(at[0], at[1])));
  };
  const auto pixel = [&](const glm::dvec3& p) { return focal / p.z * glm::dvec2(p.x, p.y); };
  double most = 0;
  for (const LodTriangle& t : mesh.triangles) {
    std::array<Corner, 3> at;
    for (std::size_t i = 0; i < 3; ++i) at[i] = corner_of(window, mesh.vertices[t[i]]);
    const auto [west, east] = std::minmax({at[0][0], at[1][0], at[2][0]});
    const auto [south, north] = std::minmax({at[0][1], at[1][1], at[2][1]});
    const int whole = area(at[0], at[1], at[2]);
    for (Corner p{west, south}; p[1] <= north;
         p = p[0] < east ? Corner{p[0] + 1, p[1]} : Corner{west, p[1] + 1}) {
      const int a = area(p, at[1], at[2]), b = area(at[0], p, at[2]), c = whole - a - b;
      if (a < 0 || b < 0 || c < 0) continue;
      const glm::dvec3 is = place(p);
      if (is.z <= 0) continue;
      const glm::dvec2 seen = pixel(is);
      if (std::abs(seen.x) > view.viewport_width_px / 2.0 || std::abs(seen.y) > view.viewport_height_px / 2.0)
        continue;
      const glm::dvec3 drawn =
          (static_cast<double>(a) * place(at[0]) + static_cast<double>(b) * place(at[1]) +
           static_cast<double>(c) * place(at[2])) /
          static_cast<double>(whole);
      most = std::max(most, drawn.z > 0 ? glm::distance(pixel(drawn), seen) : HUGE_VAL);
    }
  }
  return most;
}

/// From above the area or south of it; a height of some metres there is about the tolerance.
LodView view_of(const GeoBounds& area, std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const double width_m = (area.north - area.south) * 111e3;
  LodView view{{}, 0, true};
  view.view.eye = {between(area.west, area.east),
                   std::max(-90.0, area.south - between(0, 1) * (area.north - area.south))};
  view.view.height_m = width_m * between(0.3, 2);
  view.view.pitch_deg = between(-90, -20);
  view.view.viewport_width_px = 1280;
  view.view.viewport_height_px = 720;
  const double focal = view.view.viewport_height_px / 2.0 / std::tan(glm::radians(view.view.fov_y_deg / 2));
  view.tolerance_px = focal * between(2, 60) / view.view.height_m;
  return view;
}

TEST_CASE("A decimated mesh keeps its tolerance at every sample, its rim, and has no gaps or folds") {
  std::mt19937 random(11);
  std::size_t before = 0, after = 0;
  double tightest = 0;
  for (const LonLat& place : {LonLat{7.6, 46.2}, LonLat{-155.4, 19.4}, LonLat{30, 85.5}, LonLat{30, -89.9}}) {
    for (const int level : {-3, 0, 4}) {
      for (const int round : {0, 1, 2, 3, 4, 5, 6, 7}) {
        const bool deeper = (round & 1) != 0;
        const int relief = round / 2 * round, hole = round > 3 ? 6 : 0;
        const LodScene scene = scene_of(tile_at(place, level), deeper, relief);
        const TileWindow window(scene, scene.tiles[0]);
        const SquareErrors errors(scene, scene.tiles[0], false);
        const LodView view = view_of(tile_bounds(scene.tiles[0].area), random);
        LodMesh mesh = grid_of(window, hole);
        LodTileMesh& tile = mesh.tiles.front();
        const auto rim_before = rim(window, tile);
        before += tile.triangles.size();
        const ScreenErrorBudget budget(view.view, view.tolerance_px, scene.lowest_m);
        VertexDecimation(budget).decimate({window, errors, kQuantum_m}, tile);
        after += tile.triangles.size();
        CAPTURE(place.lon, place.lat, level, round, view.tolerance_px, view.view.height_m);
        const double off_px = most_off_px(window, tile, view.view);
        CHECK(off_px <= view.tolerance_px * (1 + 1e-6));
        tightest = std::max(tightest, off_px / view.tolerance_px);
        CHECK(rim(window, tile) == rim_before);
        if (hole > 0) continue;
        const MeshFaults faults = find_faults(scene, mesh);
        CHECK(faults.cracks == 0);
        CHECK(faults.degenerate == 0);
        CHECK(faults.area_error < 1e-12);
      }
    }
  }
  CAPTURE(before, after, tightest);
  CHECK(after < before * 2 / 3);
  CHECK(tightest > 0.8);
}

TEST_CASE("Where the Earth's curvature alone exceeds the tolerance, not even a plane is decimated") {
  const LodScene scene = scene_of(tile_at({7.6, 46.2}, 4), false, 0);
  const TileWindow window(scene, scene.tiles[0]);
  const SquareErrors errors(scene, scene.tiles[0], false);
  LodView view{{}, 1e-7, true};
  const GeoBounds bounds = tile_bounds(scene.tiles[0].area);
  view.view.eye = {(bounds.west + bounds.east) / 2, (bounds.south + bounds.north) / 2};
  view.view.height_m = 5000;
  view.view.pitch_deg = -60;
  LodMesh mesh = grid_of(window, 0);
  const std::size_t before = mesh.tiles[0].triangles.size();
  const ScreenErrorBudget budget(view.view, view.tolerance_px, scene.lowest_m);
  VertexDecimation(budget).decimate({window, errors, kQuantum_m}, mesh.tiles[0]);
  CHECK(mesh.tiles[0].triangles.size() == before);
}

}  // namespace
}  // namespace cairn::test
