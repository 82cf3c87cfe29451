// Several samples a pixel and dithering: edges and slow gradients against a picture of many more pixels.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "runtime/gl/frame_target.h"
#include "tests/support/gl_packs.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

constexpr int kWidth = 160, kHeight = 120, kFiner = 8;

double linear(std::uint8_t byte) {
  const double c = byte / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

double encoded(double c) {
  return 255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055);
}

gl::Picture drawn(Stage& stage, ViewState view, int scale, int samples) {
  view.viewport_width_px = kWidth * scale;
  view.viewport_height_px = kHeight * scale;
  const auto target = gl::FrameTarget::create(kWidth * scale, kHeight * scale, samples);
  REQUIRE(target.ok());
  // The mesh of the small picture.
  stage.look.tolerance_px = scale;
  stage.scene().cut();
  stage.scene().draw(view, 0, stage.look, target->framebuffer());
  return target->read();
}

/// The green of the pixels that the large picture shows as ground and as sky, and of the small one there.
struct EdgePixel {
  double truth = 0;
  double shown = 0;
};
std::vector<EdgePixel> edges(const gl::Picture& large, const gl::Picture& small) {
  std::vector<EdgePixel> out;
  for (int row = 0; row < kHeight; ++row) {
    for (int column = 0; column < kWidth; ++column) {
      double sum = 0;
      int sky = 0;
      for (int part = 0; part < kFiner * kFiner; ++part) {
        const std::uint8_t* p = large.pixel(column * kFiner + part % kFiner, row * kFiner + part / kFiner);
        sum += linear(p[1]);
        sky += p[0] == 255 && p[1] == 255 && p[2] == 255;
      }
      if (sky == 0 || sky == kFiner * kFiner) continue;
      out.push_back({encoded(sum / (kFiner * kFiner)), double(small.pixel(column, row)[1])});
    }
  }
  return out;
}

double rms(const std::vector<EdgePixel>& pixels) {
  double sum = 0;
  for (const EdgePixel& p : pixels) sum += (p.truth - p.shown) * (p.truth - p.shown);
  return std::sqrt(sum / static_cast<double>(pixels.size()));
}

}  // namespace

TEST_CASE("four samples a pixel show the horizon as the mean, in light, of a picture eight times as fine") {
  const TempDir dir;
  write_ridge_pack(dir.path() / "a.cairn", 0, 0);
  Stage stage(dir.path() / "a.cairn", kWidth, kHeight);
  // White over dark ground: the mean of bytes instead of light is off by as much as it gets.
  stage.look.hole_colour = glm::vec3(1);
  stage.look.fog = false;
  const ViewState view = view_at(ridge_places()[0], 6000, 30, -4);
  stage.look.to_sun = glm::normalize(camera_frame(view).position);
  stage.draw(view);
  const gl::Picture large = drawn(stage, view, kFiner, 1);
  const std::vector<EdgePixel> hard = edges(large, drawn(stage, view, 1, 1)),
                               smooth = edges(large, drawn(stage, view, 1, 4));
  REQUIRE(hard.size() > 100);
  WARN("the horizon's pixels are off by " << rms(hard) << " of 255 with one sample, by " << rms(smooth)
                                          << " with four");
  CHECK(rms(smooth) < 0.6 * rms(hard));
  double bias = 0;
  for (const EdgePixel& p : smooth) bias += p.shown - p.truth;
  CHECK(std::abs(bias / static_cast<double>(smooth.size())) < 4);
}

TEST_CASE("a picture of several samples has the depth of one, and more samples than there are is said") {
  const TempDir dir;
  write_ridge_pack(dir.path() / "a.cairn", 0, 0);
  Stage stage(dir.path() / "a.cairn", kWidth, kHeight);
  const ViewState view = view_at(ridge_places()[0], 6000, 30, -60);
  stage.draw(view);
  const auto four = gl::FrameTarget::create(kWidth, kHeight, 4);
  REQUIRE(four.ok());
  stage.scene().draw(view, 0, stage.look, four->framebuffer());
  const std::vector<float> one_depth = stage.target().read_depth(), four_depth = four->read_depth();
  REQUIRE(one_depth.size() == four_depth.size());
  // A sample lies within its pixel: its depth is between those of the pixels around.
  int outside = 0;
  for (int row = 1; row < kHeight - 1; ++row) {
    for (int column = 1; column < kWidth - 1; ++column) {
      float least = 1, most = 0;
      for (int part = 0; part < 9; ++part) {
        const float depth =
            one_depth[static_cast<std::size_t>((row + part / 3 - 1) * kWidth + column + part % 3 - 1)];
        least = std::min(least, depth);
        most = std::max(most, depth);
      }
      const float depth = four_depth[static_cast<std::size_t>(row * kWidth + column)];
      outside += depth < 0.98f * least || depth > 1.02f * most;  // a crest between them
    }
  }
  CHECK(outside < kWidth * kHeight / 1000);
  const auto many = gl::FrameTarget::create(kWidth, kHeight, 4096);
  REQUIRE(!many.ok());
  CHECK(many.error().message.find("4096") != std::string::npos);
}

TEST_CASE("dithering breaks the bands of a clear sky and changes no pixel by more than a step") {
  const TempDir dir;
  write_ridge_pack(dir.path() / "a.cairn", 0, 0);
  Stage stage(dir.path() / "a.cairn", kWidth, kHeight);
  stage.look.hole_colour.reset();
  const ViewState view = view_at(ridge_places()[0], 6000, 30, 50);
  stage.look.to_sun = glm::normalize(camera_frame(view).position);
  stage.draw(view);
  const gl::Picture bands = stage.target().read();
  stage.look.dithers = true;
  stage.draw(view);
  const gl::Picture noise = stage.target().read();
  int worst = 0;
  for (std::size_t i = 0; i < noise.rgb.size(); ++i) {
    worst = std::max(worst, std::abs(int(noise.rgb[i]) - int(bands.rgb[i])));
  }
  CHECK(worst <= 1);
  // The longest run of one colour down the picture's middle column.
  const auto longest = [](const gl::Picture& picture) {
    int run = 1, most = 1;
    for (int row = 1; row < kHeight; ++row) {
      const auto *a = picture.pixel(kWidth / 2, row - 1), *b = picture.pixel(kWidth / 2, row);
      run = std::equal(a, a + 3, b) ? run + 1 : 1;
      most = std::max(most, run);
    }
    return most;
  };
  CHECK(longest(noise) < longest(bands));
  stage.draw(view);
  CHECK(stage.target().read().rgb == noise.rgb);
}

}  // namespace cairn::test
