// Doubles until the eye is subtracted: the ground stands still under a camera that hardly moves.

#include <algorithm>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>

#include "cairn/geodesy.h"
#include "tests/support/gl_packs.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

constexpr int kWidth = 64;
constexpr int kHeight = 48;
constexpr double kPixelsOf1080Rows = 1080 / 45.0 / (kHeight / 18.0);  // of 45°, in a pixel here

ViewState near_ground(LonLat eye, double height_m, double heading_deg) {
  ViewState view = view_at(eye, height_m, heading_deg, -60);
  view.fov_y_deg = 18;
  view.viewport_width_px = kWidth;
  view.viewport_height_px = kHeight;
  return view;
}

double at(const std::vector<float>& depth, int column, int row) {
  return static_cast<double>(depth[static_cast<std::size_t>(row * kWidth + column)]);
}

/// Depths of one frame at any point of it, on the plane through the four pixels around; 1/distance is linear
/// in the picture on a plane. 0 where the four are on no plane.
double depth_between(const std::vector<float>& depth, double x, double y) {
  const double u = x - 0.5, v = y - 0.5;
  const int c = static_cast<int>(std::floor(u)), r = static_cast<int>(std::floor(v));
  if (c < 0 || r < 0 || c + 1 >= kWidth || r + 1 >= kHeight) return 0;
  const double nw = at(depth, c, r), ne = at(depth, c + 1, r), sw = at(depth, c, r + 1),
               se = at(depth, c + 1, r + 1);
  const double least = std::min({nw, ne, sw, se}), most = std::max({nw, ne, sw, se});
  if (least <= 0 || std::abs(nw + se - ne - sw) > 1e-5 * most) return 0;
  const double s = u - c, t = v - r;
  return (nw * (1 - s) + ne * s) * (1 - t) + (sw * (1 - s) + se * s) * t;
}

/// Whether the pixels around lie on one plane. Beside a silhouette the camera's step may cover the ground.
bool is_plane_around(const std::vector<float>& depth, int column, int row) {
  for (const int dy : {0, 1})
    for (const int dx : {0, 1})
      if (depth_between(depth, column + dx, row + dy) == 0) return false;
  return true;
}

struct Movement {
  double worst_px = 0;
  int pixels = 0;
};
/// How far the points that one frame shows are from the surface of the other, along the view, in pixels of a
/// picture of 1080 rows.
void compare(const ViewState& before, const std::vector<float>& first, const ViewState& after,
             const std::vector<float>& second, Movement& movement) {
  for (int row = 4; row < kHeight - 4; row += 4) {
    for (int column = 4; column < kWidth - 4; column += 4) {
      const double depth = at(first, column, row);
      if (depth == 0 || !is_plane_around(first, column, row)) continue;
      const PicturePoint there = project(after, shown_at(before, column + 0.5, row + 0.5, depth));
      const double seen = depth_between(second, there.x, there.y);
      if (seen == 0) continue;
      const double off = std::abs(gl::kNear_m / seen - there.depth_m);
      movement.worst_px =
          std::max(movement.worst_px, kPixelsOf1080Rows * off / pixel_footprint_m(after, there.depth_m));
      ++movement.pixels;
    }
  }
}

}  // namespace

TEST_CASE("the drawn ground moves less than a twentieth of a pixel when the camera moves a centimetre") {
  const TempDir dir;
  std::mt19937 random(5);
  const auto apart = [&] { return std::uniform_real_distribution<double>(-0.02, 0.02)(random); };
  Movement movement;
  for (std::size_t place = 0; place < ridge_places().size(); ++place) {
    const auto path = dir.path() / (std::to_string(place) + ".cairn");
    write_ridge_pack(path, place, place);
    Stage stage(path, kWidth, kHeight);
    stage.look.tolerance_px = 0.05;  // so that both frames draw the same mesh, but for so much
    for (int i = 0; i < 20; ++i) {
      LonLat eye = ridge_places()[place];
      eye = {std::remainder(eye.lon + apart(), 360.0), std::clamp(eye.lat + apart(), -90.0, 90.0)};
      const ViewState before = near_ground(eye, ridges_m(eye) + 1, 18.0 * i);
      ViewState after = before;
      const Geodetic moved = to_geodetic(camera_frame(before).position + camera_frame(before).right * 0.01);
      after.eye = moved.place;
      after.height_m = moved.height_m;
      stage.draw(before);
      const std::vector<float> first = stage.target().read_depth();
      stage.draw(after);
      compare(before, first, after, stage.target().read_depth(), movement);
    }
  }
  INFO("worst movement: " << movement.worst_px << " px of a 1080-row picture, at " << movement.pixels
                          << " points");
  CHECK(movement.pixels > 5000);
  CHECK(movement.worst_px < 0.05);
}

}  // namespace cairn::test
