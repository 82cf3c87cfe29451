#include <cmath>
#include <random>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>

#include "cairn/geodesy.h"
#include "runtime/lab/lab_terrain.h"
#include "runtime/lab/screen_error.h"
#include "tests/support/lod_scene.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

constexpr LonLat kMiddle{8.5, 46.5};

/// A pack of 257² tiles: a cell at level 2, and its ancestors up to level -1.
class HillPack {
 public:
  HillPack() : path_(dir_.path() / "hills.cairn") {
    TestSurface surface;
    surface.height = hills;
    std::vector<TileId> tiles;
    const TileId first = tile_at({8, 46}, 2);
    for (int dy = 0; dy < 4; ++dy) {
      for (int dx = 0; dx < 4; ++dx) tiles.push_back(neighbour_of(first, dx, dy));
    }
    write_test_pack(path_, surface, with_ancestors(tiles, -1));
  }

  LabTerrain open() const {
    Result<PackReader> pack = PackReader::open(path_);
    REQUIRE(pack.ok());
    return LabTerrain(std::make_shared<const PackReader>(std::move(*pack)));
  }

 private:
  TempDir dir_;
  std::filesystem::path path_;
};

ViewState view_of_hills(double pitch_deg) {
  ViewState view;
  view.eye = {kMiddle.lon - 0.2, kMiddle.lat - 0.2};
  view.height_m = 3000;
  view.heading_deg = 40;
  view.pitch_deg = pitch_deg;
  return view;
}

LodMesh mesh_of(const char* method, const LodScene& scene, const LodView& view) {
  const auto lod = lod_method(method)->create({});
  lod->prepare(scene);
  return lod->build(scene, view);
}

/// The pixel of a point, worked out from angles instead of scaled coordinates.
glm::dvec2 pixel(const ViewState& view, const glm::dvec3& point) {
  const CameraFrame camera = camera_frame(view);
  const glm::dvec3 to = glm::normalize(point - camera.position);
  const double off_axis = std::acos(glm::dot(to, camera.forward));
  const double around = std::atan2(glm::dot(to, camera.up), glm::dot(to, camera.right));
  const double focal = view.viewport_height_px / 2.0 / std::tan(glm::radians(view.fov_y_deg / 2));
  return focal * std::tan(off_axis) * glm::dvec2(std::cos(around), std::sin(around));
}

std::optional<glm::dvec3> point_on(const LodMesh& mesh, const LatticePoint& p) {
  const auto found = find_on(mesh, p);
  if (!found) return std::nullopt;
  glm::dvec3 point(0);
  for (std::size_t i = 0; i < 3; ++i) {
    const LodVertex& corner = found->corners[i];
    point += found->shares[i] * cairn::to_geocentric(place_of(corner.point), corner.height_m);
  }
  return point;
}

glm::dvec3 true_point(const LatticePoint& p) {
  const std::int64_t spacing = lattice_width(2) / 256;
  return cairn::to_geocentric(place_of(p), hills(p.x / spacing, p.y / spacing) * 0.25);
}

TEST_CASE("The method `full` has no screen error against its own tiles, and no holes", "[slow]") {
  const HillPack pack;
  LabTerrain terrain = pack.open();
  for (const double pitch_deg : {-90.0, -40.0, -5.0}) {
    const ViewState view = view_of_hills(pitch_deg);
    const auto scene = terrain.scene_for(view, {RefinementPattern::restricted, 1e-6});
    REQUIRE(scene.ok());
    const auto finest = FinestView::of(terrain, view, 2);
    REQUIRE(finest.ok());
    const PlacedMesh mesh = place(*scene, mesh_of("full", *scene, {view, 1, true}), 2);
    const FinestView::Before before{mesh, *finest};
    const ScreenError error = finest->measure(mesh, &before);
    CHECK(error.samples > 1000);
    CHECK(error.max_px < 2e-4);
    CHECK(error.holes == 0);
    CHECK(error.max_pop_px == 0);
  }
}

TEST_CASE("Screen error and popping are what an independent projection finds") {
  const HillPack pack;
  LabTerrain terrain = pack.open();
  const ViewState view = view_of_hills(-20);
  const auto scene = terrain.scene_for(view, {});
  REQUIRE(scene.ok());
  const auto finest = FinestView::of(terrain, view, 2);
  REQUIRE(finest.ok());
  const PlacedMesh fine = place(*scene, mesh_of("geomip", *scene, {view, 8, false}), 2);
  const PlacedMesh coarse = place(*scene, mesh_of("geomip", *scene, {view, 32, false}), 2);
  const FinestView::Before before{coarse, *finest};
  const ScreenError error = finest->measure(fine, &before);
  REQUIRE(error.holes == 0);
  CHECK(error.rms_px > 0);
  CHECK(error.rms_px < error.max_px);

  const auto distance = [&](const LatticePoint& p, const glm::dvec3& to, const LodMesh& mesh) {
    return glm::distance(pixel(view, to), pixel(view, *point_on(mesh, p)));
  };
  CHECK(distance(error.worst, true_point(error.worst), fine.mesh) == Approx(error.max_px).margin(1e-3));

  std::mt19937 random(1);
  const std::int64_t spacing = lattice_width(2) / 256;
  const LatticePoint corner = south_west_of(tile_at(kMiddle, 2));
  for (int i = 0; i < 40; ++i) {
    const LatticePoint p{corner.x + static_cast<std::int64_t>(random() % 257) * spacing,
                         corner.y + static_cast<std::int64_t>(random() % 257) * spacing};
    const glm::dvec2 at = pixel(view, true_point(p));
    if (std::abs(at.x) > 959 || std::abs(at.y) > 539) continue;
    CHECK(distance(p, true_point(p), fine.mesh) <= error.max_px + 1e-3);
    CHECK(distance(p, *point_on(coarse.mesh, p), fine.mesh) <= error.max_pop_px + 1e-3);
  }
}

TEST_CASE("What was not in the viewport before does not pop") {
  const HillPack pack;
  LabTerrain terrain = pack.open();
  const ViewState view = view_of_hills(-20);
  ViewState away = view;
  away.heading_deg += 180;
  const auto scene = terrain.scene_for(view, {});
  REQUIRE(scene.ok());
  const auto finest = FinestView::of(terrain, view, 2), elsewhere = FinestView::of(terrain, away, 2);
  REQUIRE((finest.ok() && elsewhere.ok()));
  const PlacedMesh fine = place(*scene, mesh_of("geomip", *scene, {view, 8, false}), 2);
  const PlacedMesh coarse = place(*scene, mesh_of("geomip", *scene, {view, 32, false}), 2);
  const FinestView::Before seen{coarse, *finest}, unseen{coarse, *elsewhere};
  CHECK(finest->measure(fine, &seen).max_pop_px > 0);
  CHECK(finest->measure(fine, &unseen).max_pop_px == 0);
}

TEST_CASE("A place that the mesh does not cover is a hole") {
  const HillPack pack;
  LabTerrain terrain = pack.open();
  const ViewState view = view_of_hills(-30);
  const auto scene = terrain.scene_for(view, {});
  REQUIRE(scene.ok());
  LodMesh mesh = mesh_of("block", *scene, {view, 2, true});
  mesh.tiles.erase(mesh.tiles.begin());
  const auto finest = FinestView::of(terrain, view, 2);
  REQUIRE(finest.ok());
  CHECK(finest->measure(place(*scene, std::move(mesh), 2), nullptr).holes > 0);
}

TEST_CASE("Methods that keep a tolerance keep it, culled or not, wherever the tiles allow", "[slow]") {
  const HillPack pack;
  LabTerrain terrain = pack.open();
  for (const LodMethodInfo* method : lod_methods()) {
    if (!method->keeps_tolerance) continue;
    CAPTURE(std::string(method->name));
    for (const double tolerance_px : {1.0, 6.0}) {
      for (const double pitch_deg : {-70.0, -10.0}) {
        const ViewState view = view_of_hills(pitch_deg);
        const auto scene = terrain.scene_for(view, {RefinementPattern::restricted, tolerance_px / 2});
        REQUIRE(scene.ok());
        const auto finest = FinestView::of(terrain, view, 2);
        REQUIRE(finest.ok());
        for (const bool cull : {false, true}) {
          LodMesh mesh = mesh_of(method->name.data(), *scene, {view, tolerance_px, cull});
          const ScreenError error = finest->measure(place(*scene, std::move(mesh), 2), nullptr);
          CHECK(error.max_px <= tolerance_px + 1e-3);
          CHECK(error.holes == 0);
        }
      }
    }
  }
}

}  // namespace
}  // namespace cairn::test
