// Objects in pictures: where they stand, how large, in their colours, as triangles and as billboards.

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "tests/support/object_pack.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

constexpr LonLat kMiddle{10.4, 45.4};

/// One red box, 40 m wide and 60 m high, on hills.
class BoxPack {
 public:
  BoxPack() {
    const std::vector<TileId> tiles = with_ancestors({tile_at(kMiddle, 3)}, -4);
    write_object_pack(path(), {257, 3, hills, {}}, tiles,
                      {box_model("red box", 20 * std::sqrt(2.0F), 60, {255, 0, 0}, 4)}, {{kMiddle, {}}});
  }
  std::filesystem::path path() const { return dir_.path() / "box.cairn"; }

 private:
  TempDir dir_;
};

bool is_red(const std::uint8_t* pixel) {
  return pixel[0] > 40 && pixel[1] < pixel[0] / 4 && pixel[2] < pixel[0] / 4;
}

/// Whether the pixels around one are red as it is, so that no edge goes through it.
bool is_within(const gl::Picture& picture, int column, int row) {
  for (int r = std::max(row - 1, 0); r <= std::min(row + 1, picture.height - 1); ++r) {
    for (int c = std::max(column - 1, 0); c <= std::min(column + 1, picture.width - 1); ++c) {
      if (is_red(picture.pixel(c, r)) != is_red(picture.pixel(column, row))) return false;
    }
  }
  return true;
}

/// Where a picture is red.
struct RedBox {
  int left = 1 << 20, right = -1, top = 1 << 20, bottom = -1, pixels = 0;

  RedBox() = default;
  explicit RedBox(const gl::Picture& picture) {
    for (int row = 0; row < picture.height; ++row) {
      for (int column = 0; column < picture.width; ++column) {
        if (!is_red(picture.pixel(column, row))) continue;
        left = std::min(left, column);
        right = std::max(right, column);
        top = std::min(top, row);
        bottom = std::max(bottom, row);
        ++pixels;
      }
    }
  }
};

/// Where the box, or its billboard, has to be in a picture; within the picture.
RedBox box_in(const ViewState& view, double foot_m, bool is_billboard) {
  RedBox box;
  const LocalFrame local = local_frame(kMiddle);
  const glm::dvec3 foot = to_geocentric(kMiddle, foot_m);
  const double half = is_billboard ? 20 * std::sqrt(2.0) : 20, deep = is_billboard ? 0 : 20;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::dvec3 at = foot + local.east * (corner & 1 ? half : -half) +
                          local.north * (corner & 2 ? deep : -deep) + local.up * (corner & 4 ? 60.0 : 0.0);
    const PicturePoint shown = project(view, at);
    box.left = std::min(box.left, static_cast<int>(std::floor(shown.x)));
    box.right = std::max(box.right, static_cast<int>(std::floor(shown.x)));
    box.top = std::min(box.top, static_cast<int>(std::floor(shown.y)));
    box.bottom = std::max(box.bottom, static_cast<int>(std::floor(shown.y)));
  }
  box.top = std::max(box.top, 0);
  box.bottom = std::min(box.bottom, view.viewport_height_px - 1);
  return box;
}

/// From the south, so far that the box is about so many pixels high.
ViewState view_from_south(const Stage& stage, double pixels) {
  const double distance_m = 60 * 120 / (2 * std::tan(0.3926990817) * pixels);
  ViewState view = view_at({kMiddle.lon, kMiddle.lat - distance_m / 111132}, 0, 0, 0);
  view.height_m = stage.ground_m(kMiddle) + 30 + distance_m / 8;
  view.pitch_deg = -180 / 3.14159265 * std::atan2(distance_m / 8, distance_m);
  return view;
}

}  // namespace

TEST_CASE("an object is drawn where it stands, as large as it is, near and far") {
  const BoxPack pack;
  Stage stage(pack.path());
  stage.look.fog = false;
  stage.draw(view_at(kMiddle, 3000, 0, -90));
  std::size_t near_triangles = 0;
  for (const double pixels : {90.0, 50.0, 24.0, 12.0, 6.0}) {
    const ViewState view = view_from_south(stage, pixels);
    stage.draw(view);
    const double foot_m = stage.ground_m(kMiddle);
    const SurfaceObjects& objects = stage.scene().objects();
    CAPTURE(pixels, objects.billboards, objects.triangles);
    CHECK(objects.objects == 1);
    CHECK((objects.billboards > 0) == (pixels < 32 * 60 / 56.5 * 1.25));
    const RedBox red(stage.target().read()), expected = box_in(view, foot_m, objects.billboards > 0);
    REQUIRE(red.pixels > 0);
    CHECK(std::abs(red.left - expected.left) <= 2);
    CHECK(std::abs(red.right - expected.right) <= 2);
    CHECK(std::abs(red.top - expected.top) <= 2);
    CHECK(std::abs(red.bottom - expected.bottom) <= 2);
    if (pixels == 90) near_triangles = objects.triangles;
  }
  CHECK(near_triangles > 100);
}

TEST_CASE("an object fades out towards the smallest size, and is gone below it") {
  const BoxPack pack;
  Stage stage(pack.path());
  stage.look.fog = false;
  stage.look.object_px = 10;
  stage.draw(view_at(kMiddle, 3000, 0, -90));
  int last = 1 << 20;
  for (const double pixels : {20.0, 14.0, 12.5, 11.0, 9.0}) {
    stage.draw(view_from_south(stage, pixels));
    const int red = RedBox(stage.target().read()).pixels;
    CAPTURE(pixels, red);
    CHECK(red < last);
    CHECK((red == 0) == (pixels < 10));
    last = red;
  }
}

TEST_CASE("a ray that is shot at an object meets it where the picture shows it") {
  const BoxPack pack;
  Stage stage(pack.path());
  stage.draw(view_at(kMiddle, 3000, 0, -90));
  const ViewState view = view_from_south(stage, 60);
  stage.draw(view);
  const glm::dvec3 eye = camera_frame(view).position;
  const std::vector<float> depth = stage.target().read_depth();
  const gl::Picture picture = stage.target().read();
  int hits = 0, wrong = 0;
  for (int row = 0; row < picture.height; row += 2) {
    for (int column = 0; column < picture.width; column += 2) {
      const float value = depth[static_cast<std::size_t>(row * picture.width + column)];
      if (value == 0) continue;
      const glm::dvec3 shown = shown_at(view, column + 0.5, row + 0.5, static_cast<double>(value));
      const auto hit = stage.scene().pick(eye, shown - eye);
      const bool is_near = hit && std::abs(hit->distance_m - glm::distance(eye, shown)) < 0.05;
      hits += is_near;
      if (is_within(picture, column, row)) wrong += is_near != is_red(picture.pixel(column, row));
    }
  }
  CHECK(hits > 100);
  CHECK(wrong <= 2);  // where a ray meets the ground and, less than 5 cm behind, the box
}

TEST_CASE("what is not asked for is not drawn, and the host's state is what it was") {
  const BoxPack pack;
  Stage stage(pack.path());
  stage.draw(view_at(kMiddle, 3000, 0, -90));
  stage.look.objects = false;
  stage.draw(view_from_south(stage, 60));
  CHECK(RedBox(stage.target().read()).pixels == 0);
  stage.look.objects = true;
  stage.draw(view_from_south(stage, 60));
  CHECK(RedBox(stage.target().read()).pixels > 500);
}

}  // namespace cairn::test
