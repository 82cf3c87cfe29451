// Looking down, terrain fills the picture: whatever is magenta is a hole or a crack.

#include <algorithm>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "cairn/geodesy.h"
#include "tests/support/gl_packs.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

class Dice {
 public:
  explicit Dice(unsigned seed) : random_(seed) {}
  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  double log_between(double low, double high) { return std::exp(between(std::log(low), std::log(high))); }

 private:
  std::mt19937 random_;
};

/// A camera that looks down at a place within the bounds, so that no ray passes the Earth by.
ViewState camera_over(const GeoBounds& bounds, double least_m, Dice& dice) {
  const LonLat eye{std::remainder(dice.between(bounds.west, bounds.east), 360.0),
                   std::clamp(dice.between(bounds.south, bounds.north), -90.0, 90.0)};
  const double above = dice.log_between(least_m, 2e6);
  return view_at(eye, above, dice.between(0, 360),
                 above > 3e5 ? dice.between(-90, -80) : dice.between(-90, -55));
}

/// Draws random cameras and returns how many of them saw holes, each reported.
int cameras_with_holes(Stage& stage, const GeoBounds& bounds, int count, unsigned seed) {
  Dice dice(seed);
  int bad = 0;
  for (int i = 0; i < count; ++i) {
    ViewState view = camera_over(bounds, 2, dice);
    // The ground that is loaded for the first height may be coarser than that of the second.
    const double above_m = view.height_m;
    for (int lift = 0; lift < 2; ++lift) {
      stage.scene().load_all(view);
      view.height_m = above_m + stage.ground_m(view.eye);
    }
    stage.look.tolerance_px = i % 3 == 0 ? 4 : 1;
    stage.draw(view);
    const int seen = stage.holes();
    CAPTURE(i, view.eye.lon, view.eye.lat, view.height_m, view.heading_deg, view.pitch_deg);
    CHECK(seen == 0);
    bad += seen > 0;
  }
  CHECK(stage.scene().take_errors().empty());
  return bad;
}

/// From 1,000 km high to low above a place in 150 frames that wait for nothing.
void fly_down_cold(const std::filesystem::path& pack, LonLat place) {
  Stage stage(pack);
  for (int i = 0; i < 150; ++i) {
    const double part = i / 149.0, left = 1 - part;
    const ViewState view =
        view_at({place.lon - 3 * left, std::clamp(place.lat - 2 * left, -90.0, 90.0)},
                stage.ground_m(place) + 500 + 1e6 * std::pow(left, 3), 30, i % 50 < 25 ? -80 : -60);
    stage.draw_now(view, 1 / 30.0);
    CAPTURE(i);
    REQUIRE(stage.holes() == 0);
  }
  CHECK(stage.scene().terrain().stats().tiles_loaded > 20);
  CHECK(stage.scene().terrain().stats().holes == 0);
}

}  // namespace

TEST_CASE("no random camera that looks down sees a hole in generated ridges") {
  const TempDir dir;
  for (std::size_t pack = 0; pack < 5; ++pack) {
    const auto path = dir.path() / (std::to_string(pack) + ".cairn");
    write_ridge_pack(path, pack, pack);
    Stage stage(path);
    const LonLat place = ridge_places()[pack];
    for (const double apart : {30.0, 0.3}) {
      // Beyond a pole cameras stand on it, from where the walls along meridians are seen edge-on.
      const GeoBounds near{place.lon - apart, place.lat - apart, place.lon + apart, place.lat + apart};
      CHECK(cameras_with_holes(stage, near, 25, static_cast<unsigned>(pack)) == 0);
    }
  }
}

TEST_CASE("a source's end is a wall, though the ground before it is below the picture") {
  const TempDir dir;
  const auto pack = dir.path() / "a.cairn";
  if (!bake_real_pack(pack, {"geotiff/N46E008.tif"})) return;
  Stage stage(pack);
  const ViewState view = view_at({9.05, 46.5}, 1500, 270, 10);
  stage.scene().load_all(view);
  stage.draw(view);
  const std::vector<float> depth = stage.target().read_depth();
  for (int x = 0; x < 160; ++x) {
    const auto at = static_cast<double>(depth[static_cast<std::size_t>(119 * 160 + x)]);
    REQUIRE(at > 0);
    const Geodetic shown = to_geodetic(shown_at(view, x + 0.5, 119.5, at));
    CHECK(shown.place.lon == Approx(9).margin(0.001));  // the source ends half a post beyond
  }
}

TEST_CASE(
    "no random camera that looks down sees a hole in Hawaii, in four cells of Kenya, anywhere on Earth") {
  const TempDir dir;
  const auto pack = dir.path() / "real.cairn";
  SECTION("Hawaii, DTED") {
    if (!bake_real_pack(
            pack, {"dted1/n18_w156_3arc_v2.dt1", "dted1/n19_w155_3arc_v2.dt1", "dted1/n19_w156_3arc_v2.dt1",
                   "dted1/n19_w157_3arc_v2.dt1", "dted1/n20_w156_3arc_v2.dt1"}))
      return;
    Stage stage(pack);
    CHECK(cameras_with_holes(stage, {-157.2, 17.8, -153.8, 21.2}, 167, 1) == 0);
  }
  SECTION("Kenya, 1 inch") {
    if (!bake_real_pack(pack, {"srtm1/S01E035.hgt.zip", "srtm1/S02E034.hgt.zip", "srtm1/S02E035.hgt.zip",
                               "srtm1/S02E036.hgt.zip"})) {
      return;
    }
    Stage stage(pack);
    CHECK(cameras_with_holes(stage, {33.9, -2.1, 37.1, 0.1}, 166, 2) == 0);
  }
  SECTION("the Earth with Blue Marble") {
    if (!bake_real_pack(pack, {"global/etopo5_4320x2161.tif"},
                        {"imagery/bmng_world_topo_bathy_200411_5400x2700.jpg"})) {
      return;
    }
    Stage stage(pack);
    CHECK(cameras_with_holes(stage, {-180, -90, 180, 90}, 167, 3) == 0);
  }
}

TEST_CASE("a fast flight over tiles that are still coming shows no hole") {
  const TempDir dir;
  const auto pack = dir.path() / "a.cairn";
  SECTION("generated ridges") {
    write_ridge_pack(pack, 0, 1);
    fly_down_cold(pack, ridge_places()[0]);
    fly_down_cold(pack, ridge_places()[1]);
  }
  SECTION("Kenya, 1 inch") {
    if (!bake_real_pack(pack, {"srtm1/S01E035.hgt.zip", "srtm1/S02E034.hgt.zip", "srtm1/S02E035.hgt.zip",
                               "srtm1/S02E036.hgt.zip"})) {
      return;
    }
    fly_down_cold(pack, {35.5, -1.2});
  }
}

}  // namespace cairn::test
