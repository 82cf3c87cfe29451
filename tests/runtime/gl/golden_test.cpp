// Pictures of each feature, from orbit to the ground, against those in tests/golden/pictures: not byte by
// byte, as drivers differ, but by how different they look. CAIRN_WRITE_GOLDEN=1 writes them anew; then each
// has to be looked at.

#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <catch2/catch.hpp>

#include "cairn/drape.h"
#include "cairn/tint.h"
#include "tests/support/gl_packs.h"
#include "tests/support/golden_picture.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

constexpr int kWidth = 192, kHeight = 108;
constexpr double kSameMean = 0.6, kSameWorst = 3;  // of equal pictures on two drivers
constexpr LonLat kEye{10.31, 45.72};

struct Camera {
  double height_m;
  double heading_deg;
  double pitch_deg;
};
constexpr Camera kOrbit{3e6, 0, -70}, kHigh{40000, 20, -25}, kAbove{4000, 30, -20}, kLow{1500, 30, 4};

class Painter {
 public:
  Painter() {
    write_ridge_pack(dir_.path() / "a.cairn", 0, 0);
    stage_.emplace(dir_.path() / "a.cairn", kWidth, kHeight);
    target_.emplace(*gl::FrameTarget::create(kWidth, kHeight, 4));
  }

  /// What cairn view draws by default, the sun at an azimuth of 110° and so high.
  gl::Picture draw(const Camera& camera, double sun_deg, const std::function<void(viewer::FrameLook&)>& set) {
    ViewState view = view_at(kEye, camera.height_m, camera.heading_deg, camera.pitch_deg);
    view.viewport_width_px = kWidth;
    view.viewport_height_px = kHeight;
    viewer::FrameLook look;
    look.shadows = true;
    look.dithers = true;
    look.waits_for_shadows = true;
    look.to_sun = sun_at(kEye, 110, sun_deg);
    set(look);
    stage_->scene().load_all(view);
    stage_->scene().cut();
    stage_->scene().draw(view, 0, look, target_->framebuffer());
    return target_->read();
  }

  void check(const std::string& name, const gl::Picture& drawn) {
    const PictureDifference apart = difference(drawn, golden_picture(name, drawn));
    CAPTURE(name, apart.mean, apart.worst_percent);
    CHECK(apart.mean < kSameMean);
    CHECK(apart.worst_percent < kSameWorst);
  }

 private:
  TempDir dir_;
  std::optional<Stage> stage_;
  std::optional<gl::FrameTarget> target_;
};

std::shared_ptr<const Drape> cross() {
  Drape drape;
  drape.lines.push_back({{{10.2, 45.75}, {10.35, 45.76}, {10.5, 46.1}}, {1, 0, 0}, 4});
  drape.lines.push_back({{{10.33, 45.76}}, {0, 1, 1}, 9});
  return std::make_shared<const Drape>(drape);
}

}  // namespace

TEST_CASE("pictures of each feature look as they did, and each feature shows") {
  Painter painter;
  const auto plain = [](viewer::FrameLook&) {};
  SECTION("the sky and the light of the ground, at four heights of the sun, from orbit to the ground") {
    for (const auto& [name, camera] : {std::pair("orbit", kOrbit), {"above", kAbove}, {"low", kLow}}) {
      Camera to_sun = camera;
      to_sun.heading_deg = 95;
      std::vector<gl::Picture> drawn;
      for (const int sun_deg : {45, 8, 0, -5}) {
        drawn.push_back(painter.draw(to_sun, sun_deg, plain));
        painter.check(std::string("sun-") + name + "-" + std::to_string(sun_deg), drawn.back());
      }
      for (std::size_t i = 1; i < drawn.size(); ++i) {
        CHECK(difference(drawn[i - 1], drawn[i]).mean > 3 * kSameMean);
      }
    }
  }
  SECTION("overlays, tints, water, shadows and haze") {
    struct Feature {
      std::string name;
      Camera camera;
      double sun_deg;
      std::function<void(viewer::FrameLook&)> set;
    };
    using Look = viewer::FrameLook;
    const std::vector<Feature> features = {
        {"sea", kAbove, 25, [](Look& l) { l.sea_m = 1050; }},
        {"sea-low-sun", {2500, 110, -10}, 4, [](Look& l) { l.sea_m = 1050; }},
        {"contours", kAbove, 30, [](Look& l) { l.contours_m = 100; }},
        {"slopes", kAbove, 30, [](Look& l) { l.slope_colours = true; }},
        {"no-shadows", kAbove, 6, [](Look& l) { l.shadows = false; }},
        {"no-haze", kHigh, 30, [](Look& l) { l.fog = false; }},
        {"bright", kHigh, 30, [](Look& l) { l.exposure_ev = 1; }},
        {"drape", kAbove, 30, [](Look& l) { l.drape = cross(); }},
        {"atlas", kAbove, 30, [](Look& l) { l.tint = stops_of(*tint_named("atlas"), 400, 2000); }},
        {"viridis", kAbove, 30, [](Look& l) { l.tint = stops_of(*tint_named("viridis"), 400, 2000); }},
        {"moon", kHigh, 30, [](Look& l) {
           l.tint = {{0, glm::vec3(0.2f)}, {2000, glm::vec3(0.4f)}};
         }}};
    std::map<std::pair<double, double>, gl::Picture> plain_ones;  // by height and sun
    for (const Feature& feature : features) {
      const auto [known, is_new] = plain_ones.try_emplace({feature.camera.height_m, feature.sun_deg});
      if (is_new) known->second = painter.draw(feature.camera, feature.sun_deg, plain);
      const gl::Picture &without = known->second,
                        with = painter.draw(feature.camera, feature.sun_deg, feature.set);
      painter.check(feature.name, with);
      const PictureDifference apart = difference(with, without);
      CAPTURE(feature.name, apart.mean, apart.worst_percent);
      CHECK((apart.mean > 2 * kSameMean || apart.worst_percent > 2 * kSameWorst));
      // One camera, one driver: equal pixels, whatever was drawn between.
      CHECK(painter.draw(feature.camera, feature.sun_deg, feature.set).rgb == with.rgb);
    }
  }
}

TEST_CASE("a step of exposure doubles the light of ground and sky") {
  Painter painter;
  const auto set = [](double ev) {
    return [ev](viewer::FrameLook& look) {
      look.exposure_ev = ev;
      look.dithers = false;
    };
  };
  // Dark enough that no sample is brighter than a picture can be.
  const gl::Picture one = painter.draw(kAbove, 8, set(-1)), half = painter.draw(kAbove, 8, set(-2));
  const auto linear = [](std::uint8_t byte) {
    const double c = byte / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
  };
  double sum_one = 0, sum_half = 0;
  for (std::size_t i = 0; i < one.rgb.size(); ++i) {
    // The bytes of the samples and of their mean are rounded.
    const auto step = [&](std::uint8_t byte) {
      return linear(static_cast<std::uint8_t>(std::min(byte + 1, 255))) - linear(byte);
    };
    CHECK(linear(half.rgb[i]) ==
          Approx(linear(one.rgb[i]) / 2).margin(step(half.rgb[i]) + 0.5 * step(one.rgb[i])));
    sum_one += linear(one.rgb[i]);
    sum_half += linear(half.rgb[i]);
  }
  CHECK(sum_one / sum_half == Approx(2).epsilon(0.01));
}

}  // namespace cairn::test
