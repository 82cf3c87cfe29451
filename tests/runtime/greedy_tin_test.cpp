#include "runtime/lab/greedy_tin.h"

#include <random>

#include <catch2/catch.hpp>

#include "runtime/lab/delaunay.h"
#include "tests/test_data.h"
#include "tests/test_pack.h"

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

TEST_CASE("A greedy network keeps its tolerance with fewer triangles the more it may be off") {
  const TempDir dir;
  TestSurface surface;
  surface.height = hills;
  const auto path = dir.path() / "hills.cairn";
  write_test_pack(path, surface, with_ancestors({tile_at({8.5, 46.5}, 2)}, 2));
  auto pack = PackReader::open(path);
  REQUIRE(pack.ok());
  LabTerrain terrain(std::make_shared<const PackReader>(std::move(*pack)));
  ViewState view;
  view.eye = {8.6, 46.6};
  view.height_m = 8000;
  view.pitch_deg = -60;
  std::uint64_t before = 0;
  for (const double tolerance_px : {0.25, 1.0, 4.0, 1e6}) {
    const auto tin = greedy_tin(terrain, view, tolerance_px);
    REQUIRE(tin.ok());
    CHECK(tin->samples > 1000);
    CHECK(tin->max_px <= tolerance_px);
    if (before != 0) CHECK(tin->triangles < before);
    before = tin->triangles;
  }
  CHECK(before == 2);
  const auto full = greedy_tin(terrain, view, 0);
  REQUIRE(full.ok());
  CHECK(full->max_px < 1e-3);
  CHECK(greedy_tin(terrain, view, 0, 100)->vertices == 96);
}

}  // namespace
}  // namespace cairn::test
