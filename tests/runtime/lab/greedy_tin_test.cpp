#include "runtime/lab/greedy_tin.h"

#include <cstdlib>
#include <functional>
#include <optional>
#include <random>

#include <catch2/catch.hpp>

#include "format/delaunay.h"
#include "runtime/lab/screen_error.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

TEST_CASE("A Delaunay triangulation keeps every circumcircle empty, also on lines and circles of places") {
  for (const unsigned seed : {1u, 2u, 3u}) {
    std::mt19937 random(seed);
    Delaunay net({0, 0}, {40, 40});
    for (int n = 0; n < 200; ++n) {
      const GridPlace place{1 + static_cast<std::int64_t>(random() % 39),
                            1 + static_cast<std::int64_t>(random() % 39)};
      if (std::find(net.places().begin(), net.places().end(), place) != net.places().end()) continue;
      std::size_t t = 0;
      while (!net.covers(t, place)) ++t;
      net.insert(place, t);
    }
    std::int64_t area = 0;
    for (std::size_t t = 0; t < net.triangles().size(); ++t) {
      const auto& v = net.triangles()[t].vertices;
      const GridPlace &a = net.places()[v[0]], &b = net.places()[v[1]], &c = net.places()[v[2]];
      REQUIRE(doubled_area(a, b, c) > 0);
      area += doubled_area(a, b, c);
      // The circle's middle, from the perpendicular bisectors.
      const double bx = static_cast<double>(b.column - a.column), by = static_cast<double>(b.row - a.row);
      const double cx = static_cast<double>(c.column - a.column), cy = static_cast<double>(c.row - a.row);
      const double d = 2 * (bx * cy - by * cx);
      const double ux = (cy * (bx * bx + by * by) - by * (cx * cx + cy * cy)) / d;
      const double uy = (bx * (cx * cx + cy * cy) - cx * (bx * bx + by * by)) / d;
      for (const GridPlace& p : net.places()) {
        const double x = static_cast<double>(p.column - a.column) - ux,
                     y = static_cast<double>(p.row - a.row) - uy;
        REQUIRE(x * x + y * y >= (ux * ux + uy * uy) * (1 - 1e-9));
      }
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t n = net.triangles()[t].neighbours[i];
        if (n == Delaunay::kNone) continue;
        const auto& back = net.triangles()[n].neighbours;
        REQUIRE(std::find(back.begin(), back.end(), t) != back.end());
      }
    }
    CHECK(area == 2 * 40 * 40);
  }
}

constexpr LonLat kMiddle{8.6, 46.6};

/// One tile of a surface, the finest, and a view of its middle.
class Ground {
 public:
  explicit Ground(std::function<std::int32_t(std::int64_t, std::int64_t)> height) {
    TestSurface surface;
    surface.height = std::move(height);
    const auto path = dir_.path() / "ground.cairn";
    write_test_pack(path, surface, {kTile});
    auto pack = PackReader::open(path);
    REQUIRE(pack.ok());
    terrain.emplace(std::make_shared<const PackReader>(std::move(*pack)));
  }

  static ViewState view(double pitch_deg) {
    ViewState view;
    view.eye = kMiddle;
    view.height_m = 8000;
    view.pitch_deg = pitch_deg;
    return view;
  }

  inline static const TileId kTile = tile_at(kMiddle, 2);
  std::optional<LabTerrain> terrain;

 private:
  TempDir dir_;
};

/// What the lab's measure, which knows nothing of how the network was made, finds in it.
ScreenError measure(LabTerrain& terrain, const ViewState& view, const GreedyTin& tin) {
  const CameraFrame camera = camera_frame(view);
  PlacedMesh mesh;
  mesh.areas = {Ground::kTile};
  mesh.positions.resize(1);
  mesh.mesh.tiles.push_back({0, {}, tin.faces});
  for (const GreedyTin::Vertex& v : tin.net) {
    mesh.mesh.tiles[0].vertices.push_back({v.point, 0});
    mesh.positions[0].push_back(camera.position + v.in_camera.x * camera.right + v.in_camera.y * camera.up +
                                v.in_camera.z * camera.forward);
  }
  const auto picture = FinestView::of(terrain, view, 1);
  REQUIRE(picture.ok());
  return picture->measure(mesh, nullptr);
}

TEST_CASE(
    "A greedy network keeps its tolerance at every sample, with fewer triangles the more it may be off") {
  Ground ground(hills);
  for (const double pitch_deg : {-60.0, -15.0}) {
    const ViewState view = Ground::view(pitch_deg);
    std::uint64_t before = 2 * 256 * 256;  // those of every sample
    for (const double tolerance_px : {0.25, 1.0, 4.0, 1e6}) {
      const auto tin = greedy_tin(*ground.terrain, view, tolerance_px);
      REQUIRE(tin.ok());
      CHECK(tin->samples > 1000);
      CHECK(tin->max_px <= tolerance_px);
      CHECK(tin->triangles < before);
      before = tin->triangles;
      const ScreenError error = measure(*ground.terrain, view, *tin);
      CHECK(error.samples == tin->samples);
      CHECK(error.holes == 0);
      CHECK(error.max_px == Approx(tin->max_px).margin(1e-3));
    }
    CHECK(before == 2);
    CHECK(greedy_tin(*ground.terrain, view, 0)->max_px < 1e-3);
    CHECK(greedy_tin(*ground.terrain, view, 0, 100)->vertices == 96);
  }
}

TEST_CASE("A greedy network of known ground: two triangles of a plain, few of a fold") {
  const ViewState down = Ground::view(-90);
  Ground plain([](std::int64_t, std::int64_t) { return 400; });
  CHECK(greedy_tin(*plain.terrain, down, 1)->triangles == 2);
  // A valley along a column through the picture, by a fifth of a metre a metre on both sides.
  const std::int64_t spacing = lattice_width(2) / 256;
  const std::int64_t fold = south_west_of(tile_at(kMiddle, 2)).x / spacing + 154;
  Ground valley([&](std::int64_t column, std::int64_t) {
    return static_cast<std::int32_t>(std::abs(column - fold) * 60);
  });
  const auto tin = greedy_tin(*valley.terrain, down, 2);
  REQUIRE(tin.ok());
  CHECK(tin->triangles > 2);
  CHECK(tin->triangles < 40);
  CHECK(measure(*valley.terrain, down, *tin).max_px <= 2 + 1e-3);
}

TEST_CASE("A greedy network is equal each time, and empty for an empty view") {
  Ground ground(hills);
  const auto first = greedy_tin(*ground.terrain, Ground::view(-40), 2);
  const auto second = greedy_tin(*ground.terrain, Ground::view(-40), 2);
  REQUIRE((first.ok() && second.ok()));
  CHECK(first->faces == second->faces);
  CHECK(first->max_px == second->max_px);
  const auto sky = greedy_tin(*ground.terrain, Ground::view(80), 2);
  REQUIRE(sky.ok());
  CHECK(sky->triangles == 0);
  CHECK(sky->samples == 0);
}

}  // namespace
}  // namespace cairn::test
