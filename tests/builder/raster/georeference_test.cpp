#include "builder/raster/georeference.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "builder/raster/raster_placement.h"
#include "tests/support/gdal_oracle.h"

namespace cairn {
namespace {

Georeference utm(int zone, bool north, double x0, double y0, double spacing) {
  return {Georeference::Crs::utm, zone, north, x0, y0, spacing, -spacing};
}

void check_round_trip(const Georeference& g, double columns, double rows) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit;
  double worst = 0;
  for (int i = 0; i < 1000; ++i) {
    const double c = unit(random) * columns, r = unit(random) * rows;
    const auto back = g.post_at(g.place_of(c, r));
    worst = std::max({worst, std::abs(back.column - c), std::abs(back.row - r)});
  }
  CHECK(worst < 1e-6);
}

/// Against PROJ, in metres on the ground.
void check_with_proj(const Georeference& g, const std::string& epsg) {
  std::vector<double> xy;
  for (int i = 0; i < 50; ++i) {
    xy.push_back(g.x0 + g.dx * 97 * i);
    xy.push_back(g.y0 + g.dy * 61 * i);
  }
  const auto lonlat = test::proj_transform(epsg, "EPSG:4326", xy);
  if (!lonlat || lonlat->size() != xy.size()) return;
  for (std::size_t i = 0; i < xy.size(); i += 2) {
    const LonLat p = g.place_of((xy[i] - g.x0) / g.dx, (xy[i + 1] - g.y0) / g.dy);
    // gdaltransform prints 15 digits of degrees: a nanometre.
    CHECK(std::abs(std::remainder(p.lon - (*lonlat)[i], 360)) * 111e3 < 1e-4);
    CHECK(std::abs(p.lat - (*lonlat)[i + 1]) * 111e3 < 1e-4);
  }
}

}  // namespace

TEST_CASE("Posts go to places and back, in every projection, in both hemispheres") {
  check_round_trip({Georeference::Crs::geographic, 0, true, 26, 42, 1.0 / 1200, -1.0 / 1200}, 24000, 7200);
  check_round_trip(utm(33, true, 300000, 5000000, 10), 40000, 40000);
  check_round_trip(utm(60, false, 200000, 9900000, 30), 20000, 20000);
  check_round_trip({Georeference::Crs::web_mercator, 0, true, 3e6, 5e6, 38.2, -38.2}, 20000, 20000);
}

TEST_CASE("Places of UTM and Web Mercator posts are PROJ's to a tenth of a millimetre") {
  check_with_proj(utm(33, true, 300000, 5000000, 30), "EPSG:32633");
  check_with_proj(utm(1, false, 250000, 8000000, 30), "EPSG:32701");
  check_with_proj(utm(60, true, 600000, 8900000, 30), "EPSG:32660");
  check_with_proj({Georeference::Crs::web_mercator, 0, true, -1.9e7, 1.5e7, 300, -300}, "EPSG:3857");
}

TEST_CASE("Longitudes of a UTM raster across the antimeridian go on without a jump") {
  const Georeference g = utm(60, true, 700000, 6000000, 100);
  double before = g.place_of(0, 0).lon;
  for (int c = 1; c < 3000; ++c) {
    const double lon = g.place_of(c, 0).lon;
    REQUIRE(lon > before);
    REQUIRE(lon - before < 0.01);
    before = lon;
  }
  CHECK(before > 180);
  CHECK(g.post_at({before - 360, g.place_of(2999, 0).lat}).column == Approx(2999).margin(1e-6));
}

TEST_CASE("A projected raster's bounds hold all of its posts, and little more") {
  for (const Georeference& g : {utm(33, true, 166000, 9000000, 500), utm(17, true, 200000, 200000, 500),
                                utm(56, false, 300000, 4000000, 500)}) {
    RasterInfo info;
    info.path = "x";
    info.columns = 700;
    info.rows = 900;
    info.georeference = g;
    REQUIRE(place_raster(info).ok());
    GeoBounds tight{1e9, 1e9, -1e9, -1e9};
    for (int r = 0; r < info.rows; r += 1)
      for (int c = 0; c < info.columns; c += (r == 0 || r == info.rows - 1) ? 1 : 699) {
        const LonLat p = g.place_of(c, r);
        REQUIRE(info.bounds.contains(p));
        tight = {std::min(tight.west, p.lon), std::min(tight.south, p.lat), std::max(tight.east, p.lon),
                 std::max(tight.north, p.lat)};
      }
    CHECK(tight.west - info.bounds.west < 0.02 * tight.width());
    CHECK(info.bounds.north - tight.north < 0.02 * tight.height());
  }
}

}  // namespace cairn
