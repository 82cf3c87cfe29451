// Every level-of-detail method's mesh makes the picture that the renderer's own makes.

#include <cstdlib>
#include <vector>

#include <catch2/catch.hpp>

#include "runtime/lod/lod_method.h"
#include "tests/support/gl_packs.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

/// Mean absolute difference of two pictures' bytes.
double difference(const gl::Picture& a, const gl::Picture& b) {
  REQUIRE(a.rgb.size() == b.rgb.size());
  double sum = 0;
  for (std::size_t i = 0; i < a.rgb.size(); ++i) sum += std::abs(a.rgb[i] - b.rgb[i]);
  return sum / static_cast<double>(a.rgb.size());
}

/// The method's pictures against the renderer's own, of the same places from near and far: the same, but for
/// where their tolerances leave them.
void compare(Stage& stage, const LodMethodInfo& method, LonLat place, const std::vector<double>& heights_m,
             double at_most) {
  stage.look.tolerance_px = 0.25;
  for (const double height : heights_m) {
    ViewState view = view_at(place, height, 30, height > 3e5 ? -90 : -55);
    stage.look.method = nullptr;
    stage.draw(view);
    view.height_m += stage.ground_m(place);
    stage.draw(view);
    const gl::Picture own = stage.target().read();
    stage.look.method = &method;
    stage.draw(view);
    CAPTURE(std::string(method.name), place.lon, place.lat, height);
    CHECK(stage.holes() == 0);
    CHECK(difference(own, stage.target().read()) < at_most);
  }
}

}  // namespace

TEST_CASE("each method's picture is the renderer's own, but for the tolerance") {
  const TempDir dir;
  const auto pack = dir.path() / "a.cairn";
  SECTION("generated ridges, at the antimeridian too") {
    write_ridge_pack(pack, 0, 1);
    Stage stage(pack);
    for (const LodMethodInfo* method : lod_methods()) {
      const double at_most = method->keeps_tolerance ? 3 : 8;  // of 255, on steep and narrow ridges
      compare(stage, *method, ridge_places()[0], {2500, 20000, 400000}, at_most);
      compare(stage, *method, ridge_places()[1], {2500, 20000, 400000}, at_most);
    }
  }
  SECTION("Hawaii, DTED") {
    if (!bake_real_pack(pack, {"dted1/n19_w156_3arc_v2.dt1", "dted1/n20_w156_3arc_v2.dt1"})) return;
    Stage stage(pack);
    for (const LodMethodInfo* method : lod_methods())
      compare(stage, *method, {-155.6, 19.8}, {2500, 20000}, 0.5);
  }
}

}  // namespace cairn::test
