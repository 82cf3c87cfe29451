#include "builder/resample/projection_mesh.h"

#include <cmath>

#include <catch2/catch.hpp>

#include "builder/raster/georeference.h"

namespace cairn {

TEST_CASE("a mesh of the projection is within 1e-4 post of it at any latitude") {
  for (const double lat : {-79.0, -33.0, 0.5, 46.2, 70.0, 83.5}) {
    for (const double samples_per_degree : {128.0, 2048.0, 16384.0}) {
      for (const auto crs : {Georeference::Crs::utm, Georeference::Crs::web_mercator}) {
        Georeference g{crs, 33, true, 0, 0, 111000 / samples_per_degree, -111000 / samples_per_degree};
        const auto post_at = [&](std::int64_t x, std::int64_t y) {
          const auto post = g.post_at({static_cast<double>(x) / samples_per_degree - 180,
                                       static_cast<double>(y) / samples_per_degree - 90});
          return PlanePoint{post.column, post.row};
        };
        const auto x = static_cast<std::int64_t>(197.2 * samples_per_degree);
        const auto y = static_cast<std::int64_t>((lat + 90) * samples_per_degree);
        const IndexWindow window{{x, x + 60}, {y, y + 60}};
        const ProjectionMesh mesh(window, projection_mesh_step(samples_per_degree), 1e-4, post_at);
        std::vector<PlanePoint> row(61);
        for (std::int64_t j = y; j <= y + 60; j += 7) {
          mesh.row(j, row);
          for (std::int64_t i = x; i <= x + 60; ++i) {
            const PlanePoint exact = post_at(i, j);
            const PlanePoint& near = row[static_cast<std::size_t>(i - x)];
            CAPTURE(lat, samples_per_degree, i - x, j - y);
            REQUIRE(std::hypot(near.x - exact.x, near.y - exact.y) < 1e-4);
          }
        }
      }
    }
  }
}

TEST_CASE("a mesh gives the same places in every window") {
  const auto map = [](std::int64_t x, std::int64_t y) {
    return PlanePoint{std::sin(static_cast<double>(x) / 300), std::cos(static_cast<double>(x + 2 * y) / 500)};
  };
  const IndexWindow wide{{-100, 200}, {-50, 90}};
  const IndexWindow narrow{{-37, 11}, {3, 20}};
  const ProjectionMesh a(wide, 16, 1e-4, map);
  const ProjectionMesh b(narrow, 16, 1e-4, map);
  std::vector<PlanePoint> row_a(301), row_b(49);
  for (std::int64_t y = 3; y <= 20; ++y) {
    a.row(y, row_a);
    b.row(y, row_b);
    for (std::size_t i = 0; i < 49; ++i) {
      REQUIRE(row_a[i + 63].x == row_b[i].x);
      REQUIRE(row_a[i + 63].y == row_b[i].y);
    }
  }
}

TEST_CASE("around a pole a mesh gives every wanted place, and only places well outside as none") {
  // A polar stereographic plane's longitude and colatitude, in samples of 1/1024 degree.
  const auto map = [](std::int64_t x, std::int64_t y) {
    const double east = static_cast<double>(x) - 3.3, north = static_cast<double>(y) + 7.1;
    return PlanePoint{std::atan2(east, -north) * 58671, std::hypot(east, north) * 1.9};
  };
  const auto tolerance = [](const PlanePoint& at) { return PlanePoint{1e-5 * 58671 / (at.y + 1), 1e-5}; };
  const IndexWindow window{{-300, 420}, {-400, 410}};
  const ProjectionMesh::Box wanted{{20000, 100}, {26000, 700}};
  const ProjectionMesh mesh(window, 16, tolerance, map, wanted);
  std::vector<PlanePoint> row(721);
  int inside = 0, none = 0;
  for (std::int64_t y = window.y.first; y <= window.y.last; ++y) {
    mesh.row(y, row);
    for (std::int64_t x = window.x.first; x <= window.x.last; ++x) {
      const PlanePoint exact = map(x, y), &near = row[static_cast<std::size_t>(x - window.x.first)];
      if (std::isnan(near.x)) {
        ++none;
        REQUIRE(!(exact.x >= wanted.least.x && exact.x <= wanted.most.x && exact.y >= wanted.least.y &&
                  exact.y <= wanted.most.y));
        continue;
      }
      ++inside;
      CAPTURE(x, y);
      REQUIRE(std::abs(near.x - exact.x) <= 3 * tolerance(exact).x);
      REQUIRE(std::abs(near.y - exact.y) <= 3e-5);
    }
  }
  CHECK(inside > 10000);
  CHECK(none > inside);
}

TEST_CASE("a mesh is the map itself where the map breaks, bends sharply or has no place") {
  const auto breaks = [](std::int64_t x, std::int64_t y) {
    const double bend = std::abs(static_cast<double>(x + y) - 71.3);
    if (y > 90) return PlanePoint{NAN, NAN};
    return PlanePoint{std::remainder(static_cast<double>(x), 101), bend};
  };
  const IndexWindow window{{-120, 130}, {0, 100}};
  const ProjectionMesh mesh(window, 16, 1e-6, breaks);
  std::vector<PlanePoint> row(251);
  for (std::int64_t y = 0; y <= 100; ++y) {
    mesh.row(y, row);
    for (std::int64_t x = -120; x <= 130; ++x) {
      const PlanePoint exact = breaks(x, y), &near = row[static_cast<std::size_t>(x + 120)];
      CAPTURE(x, y);
      if (std::isnan(exact.x)) {
        REQUIRE(std::isnan(near.x));
      } else {
        REQUIRE(near.x == Approx(exact.x).margin(1e-5));
        // The bend crosses cells whose centres it may miss: there the error is that of a cubic across a
        // corner.
        REQUIRE(std::abs(near.y - exact.y) < 16);
      }
    }
  }
}

}  // namespace cairn
