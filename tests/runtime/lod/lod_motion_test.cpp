// What the papers say of moving cameras: continuous methods do not jump, geometry clipmaps take the same
// triangles over any ground, and ROAM's mesh of one frame does not depend on those before.

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "runtime/lab/lab_terrain.h"
#include "runtime/lod/lod_method.h"
#include "tests/support/lod_scene.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

constexpr LonLat kMiddle{8.5, 46.5};

/// Tiles of 257² of one level around the middle, over hills or a plain.
LodScene scene_of(bool flat) {
  TestSurface surface;
  surface.height = hills;
  LodScene scene{surface.tile_size, 0.25, 0, {}};
  const TileId first = tile_at({8, 46}, 2);
  for (int i = 0; i < 16; ++i) {
    LodTile tile;
    tile.area = tile.source = neighbour_of(first, i % 4, i / 4);
    HeightTile heights = surface.tile(tile.area);
    if (flat) std::fill(heights.samples.begin(), heights.samples.end(), 4000);
    const auto [low, high] = std::minmax_element(heights.samples.begin(), heights.samples.end());
    tile.min_m = *low * 0.25, tile.max_m = *high * 0.25;
    tile.heights = std::make_shared<const HeightTile>(std::move(heights));
    tile.volume = bounding_volume(tile_bounds(tile.area), tile.min_m, tile.max_m, Occluder(0));
    scene.tiles.push_back(std::move(tile));
  }
  return scene;
}

ViewState view_at(LonLat eye, double height_m) {
  ViewState view;
  view.eye = eye;
  view.height_m = height_m;
  view.pitch_deg = -30;
  return view;
}

double height_on(const LodMesh& mesh, const LatticePoint& p) {
  const auto found = find_on(mesh, p);
  REQUIRE(found);
  double height_m = 0;
  for (std::size_t i = 0; i < 3; ++i) height_m += found->shares[i] * found->corners[i].height_m;
  return height_m;
}

/// The largest change of height at fixed places from one frame to the next, on a way of 0.004° in so many
/// steps.
double largest_jump_m(const char* method, bool geomorph, double tolerance_px, const LodScene& scene,
                      int steps) {
  std::mt19937 random(5);
  std::vector<LatticePoint> places;
  for (int i = 0; i < 30; ++i) {
    const double lon = std::uniform_real_distribution<double>(8.4, 8.6)(random);
    const double lat = std::uniform_real_distribution<double>(46.4, 46.6)(random);
    places.push_back({static_cast<std::int64_t>(std::ldexp(lon + 180, kLatticeLevel)),
                      static_cast<std::int64_t>(std::ldexp(lat + 90, kLatticeLevel))});
  }
  const auto lod = lod_method(method)->create({false, false, geomorph});
  lod->prepare(scene);
  std::vector<double> before;
  double largest = 0;
  for (int step = 0; step <= steps; ++step) {
    const LonLat eye{kMiddle.lon + 0.004 * step / steps, kMiddle.lat + 0.002 * step / steps};
    const LodMesh mesh = lod->build(scene, {view_at(eye, 1500), tolerance_px, false});
    for (std::size_t i = 0; i < places.size(); ++i) {
      const double height_m = height_on(mesh, places[i]);
      if (step == 0) {
        before.push_back(height_m);
      } else {
        largest = std::max(largest, std::abs(height_m - before[i]));
        before[i] = height_m;
      }
    }
  }
  return largest;
}

TEST_CASE("Continuous methods move with the camera, discrete ones jump", "[slow]") {
  const LodScene scene = scene_of(false);
  const auto is_continuous = [&](const char* method, bool geomorph, double tolerance_px) {
    const double coarse = largest_jump_m(method, geomorph, tolerance_px, scene, 3);
    const double fine = largest_jump_m(method, geomorph, tolerance_px, scene, 48);
    CAPTURE(method, geomorph, coarse, fine);
    CHECK(coarse > 0);
    CHECK(fine > 0);
    return fine < coarse / 5;
  };
  CHECK(is_continuous("cdlod", false, 8));
  CHECK(is_continuous("clipmap", false, 8));
  CHECK_FALSE(is_continuous("block", false, 0.5));
  CHECK_FALSE(is_continuous("geomip", false, 8));
}

// What is left is beside coarser blocks, where a change of level joins other vertices.
TEST_CASE("Geomorphing leaves less than a quarter of the jumps of block") {
  const LodScene scene = scene_of(false);
  CHECK(largest_jump_m("block", true, 0.5, scene, 48) < largest_jump_m("block", false, 0.5, scene, 48) / 4);
}

TEST_CASE("clipmap takes as many triangles over hills as over a plain") {
  const LodScene hilly = scene_of(false), flat = scene_of(true);
  for (const double tolerance_px : {1.0, 4.0}) {
    const auto triangles = [&](const LodScene& scene) {
      const auto lod = lod_method("clipmap")->create({});
      lod->prepare(scene);
      return lod->build(scene, {view_at(kMiddle, 3000), tolerance_px, false}).triangle_count();
    };
    CHECK(triangles(hilly) == triangles(flat));
  }
}

/// All of a mesh's triangles as the places of their corners, sorted.
std::vector<std::array<std::int64_t, 6>> triangles_of(const LodMesh& mesh) {
  std::vector<std::array<std::int64_t, 6>> all;
  for (const LodTileMesh& tile : mesh.tiles) {
    for (const LodTriangle& t : tile.triangles) {
      std::array<std::array<std::int64_t, 2>, 3> corners{};
      for (std::size_t k = 0; k < 3; ++k)
        corners[k] = {tile.vertices[t[k]].point.x, tile.vertices[t[k]].point.y};
      std::sort(corners.begin(), corners.end());
      all.push_back(
          {corners[0][0], corners[0][1], corners[1][0], corners[1][1], corners[2][0], corners[2][1]});
    }
  }
  std::sort(all.begin(), all.end());
  return all;
}

TEST_CASE("roam's mesh is the one that it would make anew, whatever it has flown before") {
  LodScenes scenes;
  std::mt19937 random(9);
  const auto flown = lod_method("roam")->create({});
  std::size_t most = 0;
  LodScene scene = scenes.around({27.9, 36.9}, random);
  ViewState view = random_view({27.9, 36.9}, random);
  for (int frame = 0; frame < 300; ++frame) {
    // Small steps over one scene, now and then other tiles, a jump, or another tolerance.
    if (frame % 7 == 6) scene = scenes.around({27.9, 36.9}, random);
    if (frame % 31 == 30) view = random_view({27.9, 36.9}, random);
    view.eye.lon += std::uniform_real_distribution<double>(-0.01, 0.01)(random);
    view.height_m =
        std::max(1300.0, view.height_m * std::uniform_real_distribution<double>(0.8, 1.25)(random));
    view.heading_deg += 20;
    const LodView shown{view, frame < 200 ? 2.0 : 0.5, false};
    flown->prepare(scene);
    const auto anew = lod_method("roam")->create({});
    anew->prepare(scene);
    const auto expected = triangles_of(anew->build(scene, shown));
    CAPTURE(frame);
    REQUIRE(triangles_of(flown->build(scene, shown)) == expected);
    most = std::max(most, expected.size());
  }
  CHECK(most > 3000);
}

}  // namespace
}  // namespace cairn::test
