#include <array>

#include <catch2/catch.hpp>

#include "runtime/lab/watertight.h"
#include "tests/support/lod_scene.h"

namespace cairn::test {
namespace {

/// Ordinary ground, on a border of 1° cells, across the antimeridian, and at both poles.
constexpr std::array kPlaces{LonLat{7.6, 46.2}, LonLat{27.9, 36.9}, LonLat{179.7, -16.3}, LonLat{12.3, 89.3},
                             LonLat{-70.4, -89.9}};

void check_random_cameras(const LodMethodInfo& method, LodScenes& scenes, int cameras) {
  std::mt19937 random(1);
  MeshFaults sum;
  for (int i = 0; i < cameras; ++i) {
    const LonLat place = kPlaces[static_cast<std::size_t>(i) % kPlaces.size()];
    const LodScene scene = scenes.around(place, random);
    const auto lod = method.create({random() % 2 == 0, random() % 2 == 0, random() % 2 == 0});
    lod->prepare(scene);
    const double tolerance_px = std::exp2(static_cast<int>(random() % 7) - 2);
    const LodMesh mesh = lod->build(scene, {random_view(place, random), tolerance_px, false});
    const MeshFaults faults = find_faults(scene, mesh);
    sum.cracks += faults.cracks;
    sum.degenerate += faults.degenerate;
    sum.area_error = std::max(sum.area_error, faults.area_error);
  }
  CHECK(sum.cracks == 0);
  CHECK(sum.degenerate == 0);
  CHECK(sum.area_error < 1e-12);
}

/// A section for each method, so that one can be run by itself.
void check_all_methods(LodScenes& scenes, int cameras) {
  for (const LodMethodInfo* method : lod_methods()) {
    DYNAMIC_SECTION(std::string(method->name)) {
      check_random_cameras(*method, scenes, cameras);
    }
  }
}

TEST_CASE("No method's mesh has cracks from 1000 random cameras over tiles of mixed levels", "[slow]") {
  LodScenes scenes;
  check_all_methods(scenes, 1000);
}

TEST_CASE("No method's mesh has cracks where tiles disagree about the heights under voids", "[slow]") {
  LodScenes scenes(true);
  check_all_methods(scenes, 100);
}

TEST_CASE("A mesh with a corner moved, a triangle missing or turned is found faulty") {
  LodScenes scenes;
  std::mt19937 random(3);
  const LodScene scene = scenes.around({7.6, 46.2}, random);
  const auto full = lod_method("full")->create({});
  full->prepare(scene);
  const LodMesh good = full->build(scene, {{}, 1, false});
  REQUIRE(find_faults(scene, good).cracks == 0);

  LodMesh moved = good;
  moved.tiles[0].vertices[40].height_m += 1;
  CHECK(find_faults(scene, moved).cracks == 0);  // the whole fan moves with it: inside a tile that is a hill
  const std::size_t corner = LodScenes::kTileSize - 1;
  moved.tiles[0].vertices[corner].height_m += 1;
  CHECK(find_faults(scene, moved).cracks > 0);

  LodMesh missing = good;
  missing.tiles[0].triangles.pop_back();
  CHECK(find_faults(scene, missing).cracks > 0);
  CHECK(find_faults(scene, missing).area_error > 0);

  LodMesh turned = good;
  std::swap(turned.tiles[0].triangles[7][0], turned.tiles[0].triangles[7][1]);
  CHECK(find_faults(scene, turned).cracks > 0);
  CHECK(find_faults(scene, turned).degenerate == 1);
}

}  // namespace
}  // namespace cairn::test
