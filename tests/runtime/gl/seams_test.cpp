// Light knows no tiles: where two meet, shading goes on as it does inside of them.

#include <cmath>
#include <cstdlib>

#include <catch2/catch.hpp>

#include "tests/support/gl_packs.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

/// Mean absolute differences of neighbouring pixels' colours, one channel.
struct Steps {
  double across = 0;  ///< where a tile ends between the two
  double inside = 0;  ///< near by, on both sides of it
};

/// A picture that looks straight down at a meridian on which tiles end.
Steps steps_at(Stage& stage, LonLat border, double above_m) {
  ViewState view = view_at(border, 0, 0, -90);
  stage.draw(view);
  view.height_m = stage.ground_m(border) + above_m;
  stage.look.fog = false;
  stage.look.to_sun = viewer::sun_direction(border, 8);
  stage.draw(view);
  const gl::Picture picture = stage.target().read();
  const auto step = [&](std::size_t column) {
    double sum = 0;
    for (std::size_t row = 0; row < 120; ++row) {
      const std::size_t at = (row * 160 + column) * 3;
      sum += std::abs(picture.rgb[at] - picture.rgb[at - 3]);
    }
    return sum / 120;
  };
  Steps steps{step(80), 0};
  for (std::size_t away = 1; away <= 20; ++away) steps.inside += (step(80 - away) + step(80 + away)) / 40;
  return steps;
}

}  // namespace

TEST_CASE("shading has no step where tiles meet, however near the eye") {
  const TempDir dir;
  const auto pack = dir.path() / "a.cairn";
  if (!bake_real_pack(pack, {"dted1/n19_w156_3arc_v2.dt1", "dted1/n20_w156_3arc_v2.dt1"})) return;
  Stage stage(pack);
  double across = 0, inside = 0;
  for (int i = 0; i < 40; ++i) {
    // Tiles of level 2 and finer end at this meridian, on Kohala and Mauna Kea's slopes.
    const Steps steps = steps_at(stage, {-155.75, 19.65 + 0.013 * i}, 60);
    across += steps.across;
    inside += steps.inside;
  }
  INFO("mean steps of colour: " << across / 40 << " across the border, " << inside / 40 << " inside");
  CHECK(inside > 0);
  CHECK(across <= 1.25 * inside);
}

}  // namespace cairn::test
