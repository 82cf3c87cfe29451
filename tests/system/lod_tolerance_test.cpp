// The methods that promise a tolerance, held against it by an oracle that shares nothing with them or the
// lab: samples straight from the pack, triangles found by trying them all, pixels from angles.

#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <random>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vec2.hpp>

#include "cairn/build.h"
#include "cairn/geodesy.h"
#include "format/rqt_block.h"
#include "format/rqt_triangulate.h"
#include "runtime/lab/lab_terrain.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn {
namespace {

namespace fs = std::filesystem;

std::shared_ptr<const PackReader> open_pack(const fs::path& path) {
  auto pack = PackReader::open(path);
  REQUIRE(pack.ok());
  return std::make_shared<const PackReader>(std::move(*pack));
}

std::shared_ptr<const PackReader> bake(const fs::path& input, const fs::path& target, float rqt_m) {
  BuildOptions options;
  options.mosaic.inputs = {input};
  options.session.target = target;
  options.session.threads = 2;
  options.heights.rqt_tolerance_m = rqt_m;
  options.grid.top = -3;
  const auto report = build(options, [](const Progress&) { return true; });
  INFO((report.ok() ? "" : report.error().message));
  REQUIRE(report.ok());
  return open_pack(target);
}

struct Sample {
  LatticePoint point;
  glm::dvec3 at{0};
};

/// Finest samples around a place, of tiles of the pack's finest level.
class Samples {
 public:
  explicit Samples(std::shared_ptr<const PackReader> pack)
      : pack_(std::move(pack)), finest_(pack_->levels(Layer::heights)->finest) {}

  std::optional<Sample> near(LonLat place, std::mt19937& random) {
    const TileId id = tile_at(place, finest_);
    const auto entry = pack_->find(Layer::heights, id);
    if (!entry) return std::nullopt;
    auto& tile = tiles_[id];
    if (tile.samples.empty()) {
      auto read = pack_->read_height_tile(*entry);
      REQUIRE(read.ok());
      tile = std::move(*read);
    }
    const auto column = static_cast<int>(random() % static_cast<unsigned>(tile.size));
    const auto row = static_cast<int>(random() % static_cast<unsigned>(tile.size));
    if (tile.is_void(column, row)) return std::nullopt;
    const std::int64_t spacing = lattice_width(finest_) / (tile.size - 1);
    const LatticePoint corner = south_west_of(id);
    const LatticePoint point{corner.x + column * spacing, corner.y + row * spacing};
    return Sample{point, to_geocentric(place_of(point), tile.at(column, row) * pack_->header().quantum_m)};
  }

 private:
  std::shared_ptr<const PackReader> pack_;
  int finest_;
  std::map<TileId, HeightTile> tiles_;
};

/// Pixels from the picture's middle, from the angles that the eye sees; nullopt outside the picture.
std::optional<glm::dvec2> pixel(const ViewState& view, const glm::dvec3& point) {
  const CameraFrame camera = camera_frame(view);
  const glm::dvec3 to = point - camera.position;
  if (glm::dot(to, camera.forward) < 1) return std::nullopt;
  const double off_axis = std::acos(std::min(1.0, glm::dot(to, camera.forward) / glm::length(to)));
  const double around = std::atan2(glm::dot(to, camera.up), glm::dot(to, camera.right));
  const double focal = view.viewport_height_px / 2.0 / std::tan(glm::radians(view.fov_y_deg / 2));
  return focal * std::tan(off_axis) * glm::dvec2(std::cos(around), std::sin(around));
}

bool is_in_picture(const ViewState& view, const glm::dvec2& p) {
  return std::abs(p.x) <= view.viewport_width_px / 2.0 && std::abs(p.y) <= view.viewport_height_px / 2.0;
}

double cross(const LatticePoint& o, const LatticePoint& a, const LatticePoint& b) {
  return static_cast<double>(a.x - o.x) * static_cast<double>(b.y - o.y) -
         static_cast<double>(b.x - o.x) * static_cast<double>(a.y - o.y);
}

std::optional<glm::dvec3> point_on(const LodMesh& mesh, const LatticePoint& p) {
  for (const LodTileMesh& tile : mesh.tiles) {
    for (const LodTriangle& t : tile.triangles) {
      const LodVertex &a = tile.vertices[t[0]], &b = tile.vertices[t[1]], &c = tile.vertices[t[2]];
      const double u = cross(p, b.point, c.point), v = cross(p, c.point, a.point),
                   w = cross(p, a.point, b.point);
      if (u < 0 || v < 0 || w < 0) continue;
      const auto at = [](const LodVertex& x) { return to_geocentric(place_of(x.point), x.height_m); };
      return (u * at(a) + v * at(b) + w * at(c)) / (u + v + w);
    }
  }
  return std::nullopt;
}

ViewState random_view(const LabTerrain& terrain, std::mt19937& random, double ground_m) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const auto& areas = terrain.finest();
  const GeoBounds area = tile_bounds(areas[random() % areas.size()].area);
  ViewState view;
  view.eye = {between(area.west, area.east), between(area.south, area.north)};
  view.height_m = ground_m + 200 * std::pow(100.0, between(0, 1));
  view.heading_deg = between(0, 360);
  view.pitch_deg = between(-90, -5);
  view.roll_deg = between(-30, 30);
  view.fov_y_deg = between(30, 75);
  view.viewport_width_px = 1280;
  view.viewport_height_px = 720;
  return view;
}

void check_tolerances(const std::shared_ptr<const PackReader>& pack, int cameras, double highest_m) {
  LabTerrain terrain(pack);
  Samples samples(pack);
  std::mt19937 random(11);
  std::size_t checked = 0;
  for (int i = 0; i < cameras; ++i) {
    const ViewState view = random_view(terrain, random, highest_m);
    const double tolerance_px = std::exp2(static_cast<double>(random() % 4) - 1);
    terrain.forget_eye();
    const auto scene = terrain.scene_for(view, {RefinementPattern::restricted, tolerance_px / 2});
    REQUIRE(scene.ok());
    std::vector<Sample> seen;
    for (int tries = 0; tries < 3000 && seen.size() < 60; ++tries) {
      const GeoBounds area = tile_bounds(terrain.finest()[random() % terrain.finest().size()].area);
      const LonLat place{(area.west + area.east) / 2, (area.south + area.north) / 2};
      const auto sample = samples.near(place, random);
      // The horizon is farther away from 200 m above the highest ground.
      if (!sample || glm::distance(sample->at, camera_frame(view).position) > 50e3) continue;
      const auto at = pixel(view, sample->at);
      if (at && is_in_picture(view, *at)) seen.push_back(*sample);
    }
    for (const LodMethodInfo* method : lod_methods()) {
      // `full` draws every sample, and takes longer than all others together.
      if (!method->keeps_tolerance || method->name == "full") continue;
      const std::string name(method->name);
      const auto lod = method->create({});
      lod->prepare(*scene);
      const LodMesh mesh = lod->build(*scene, {view, tolerance_px, true});
      for (const Sample& sample : seen) {
        const auto drawn = point_on(mesh, sample.point);
        CAPTURE(name, i, tolerance_px, sample.point.x, sample.point.y);
        REQUIRE(drawn);
        const auto truth_px = pixel(view, sample.at), drawn_px = pixel(view, *drawn);
        REQUIRE((truth_px && drawn_px));
        CHECK(glm::distance(*truth_px, *drawn_px) <= tolerance_px);
        ++checked;
      }
    }
  }
  CHECK(checked > static_cast<std::size_t>(cameras) * 30);
}

}  // namespace

TEST_CASE("Methods that keep a tolerance keep it over mountains, whatever the camera", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const test::TempDir dir;
  check_tolerances(bake(*data / "srtm3/N44W072.hgt", dir.path() / "a.cairn", 2), 12, 1950);
}

TEST_CASE("Methods that keep a tolerance keep it over an island with cliffs", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const test::TempDir dir;
  check_tolerances(bake(*data / "dted1/n20_w156_3arc_v2.dt1", dir.path() / "a.cairn", 5), 12, 4210);
}

TEST_CASE("Methods that keep a tolerance keep it over the repository's sample and over made-up hills") {
  const test::TempDir dir;
  check_tolerances(bake(test::sample_dem() / "jacksboro_fault.tif", dir.path() / "a.cairn", 1), 6, 1000);
  test::TestSurface surface;
  surface.height = test::hills;
  std::vector<TileId> tiles;
  const TileId first = tile_at({8, 46}, 2);
  for (int i = 0; i < 16; ++i) tiles.push_back(neighbour_of(first, i % 4, i / 4));
  const auto all = test::with_ancestors(tiles, 2);
  test::write_test_pack(dir.path() / "b.cairn", surface, all);
  check_tolerances(open_pack(dir.path() / "b.cairn"), 6, 300);
}

TEST_CASE("rqt draws from a pack's flags what it would have worked out from the heights") {
  const test::TempDir dir;
  const auto pack = bake(test::sample_dem() / "jacksboro_fault.tif", dir.path() / "a.cairn", 1);
  LabTerrain terrain(pack);
  std::mt19937 random(4);
  const ViewState view = random_view(terrain, random, 500);
  auto scene = terrain.scene_for(view, {});
  REQUIRE(scene.ok());
  std::size_t with_flags = 0;
  LodScene anew = *scene;
  for (LodTile& tile : anew.tiles) {
    if (!tile.flags) continue;
    ++with_flags;
    const bool rising = root_rises(tile.source);
    const auto stored = decode_rqt_block(*tile.flags, scene->tile_size, rising);
    REQUIRE(stored.ok());
    tile.flags = std::make_shared<const std::vector<std::byte>>(encode_rqt_block(
        {stored->tolerance_m, stored->steps,
         triangulate(*tile.heights, scene->quantum_m, stored->tolerance_m, stored->steps, rising)}));
  }
  CHECK(with_flags > 0);
  const auto triangles = [&](const LodScene& of) {
    const auto lod = lod_method("rqt")->create({});
    lod->prepare(of);
    return lod->build(of, {view, 2, false}).triangle_count();
  };
  // The stored ones have what their neighbours need, which the mesh gets in either case.
  CHECK(triangles(*scene) == triangles(anew));
}

}  // namespace cairn
