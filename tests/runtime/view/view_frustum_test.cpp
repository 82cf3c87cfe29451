#include "runtime/view/view_frustum.h"

#include <cmath>
#include <random>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "cairn/tile_id.h"

namespace cairn {
namespace {

class Scene {
 public:
  explicit Scene(std::uint64_t seed) : random_(seed) {}

  double between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  ViewState view() {
    ViewState view;
    view.eye = {between(-180, 180), between(-90, 90)};
    view.height_m = std::exp(between(std::log(50.0), std::log(2e7)));
    view.heading_deg = between(0, 360);
    view.pitch_deg = between(-90, 30);
    view.roll_deg = between(-180, 180);
    view.fov_y_deg = between(20, 90);
    return view;
  }
  TileId tile(LonLat near) {
    const int level = static_cast<int>(random_() % 14) + kMinLevel;
    const double reach = 4 * tile_width_degrees(level);
    const double lat = std::clamp(near.lat + between(-reach, reach), -90.0, 90.0);
    return tile_at({near.lon + between(-reach, reach), lat}, level);
  }
  LonLat place(const GeoBounds& b) {
    return {between(b.west, std::min(b.east, 180.0)), between(b.south, std::min(b.north, 90.0))};
  }

 private:
  std::mt19937_64 random_;
};

bool in_picture(const ViewState& view, const glm::dvec3& point) {
  const CameraFrame camera = camera_frame(view);
  const glm::dvec3 to = point - camera.position;
  const double depth = glm::dot(to, camera.forward);
  const double top = std::tan(glm::radians(view.fov_y_deg) / 2);
  const double side = top * view.viewport_width_px / view.viewport_height_px;
  return depth > 0 && std::abs(glm::dot(to, camera.up)) <= top * depth &&
         std::abs(glm::dot(to, camera.right)) <= side * depth;
}

/// Whether the segment enters the ellipsoid: the smallest value of the quadratic on it.
bool hidden_by_ellipsoid(const glm::dvec3& from, const glm::dvec3& to, const glm::dvec3& radii) {
  const glm::dvec3 a = from / radii;
  const glm::dvec3 d = to / radii - a;
  const double nearest = std::clamp(-glm::dot(a, d) / glm::dot(d, d), 0.0, 1.0);
  const glm::dvec3 p = a + nearest * d;
  return glm::dot(p, p) < 1;
}

bool in_box(const BoundingVolume& volume, const glm::dvec3& point) {
  for (const glm::dvec3& half : volume.half_axes) {
    if (std::abs(glm::dot(point - volume.centre, half)) > glm::dot(half, half)) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("geocentric places go there and back") {
  Scene scene(1);
  for (int i = 0; i < 1000; ++i) {
    const LonLat place{scene.between(-180, 180), scene.between(-90, 90)};
    const double height = scene.between(-1000, 1e6);
    const Geodetic back = to_geodetic(to_geocentric(place, height));
    REQUIRE(back.height_m == Approx(height).margin(1e-7));
    REQUIRE(back.place.lat == Approx(place.lat).margin(1e-11));
    REQUIRE(std::remainder(back.place.lon - place.lon, 360) == Approx(0).margin(1e-9));
  }
  CHECK(to_geocentric({0, 0}, 0).x == Ellipsoid().semi_major_m);
  CHECK(to_geocentric({0, 90}, 0).z == Approx(Ellipsoid().semi_minor_m).epsilon(1e-15));
}

TEST_CASE("the camera's axes are square to each other and look where heading and pitch say") {
  Scene scene(2);
  for (int i = 0; i < 200; ++i) {
    const ViewState view = scene.view();
    const CameraFrame c = camera_frame(view);
    REQUIRE(glm::length(glm::cross(c.forward, c.up) - c.right) < 1e-12);
    REQUIRE(std::abs(glm::dot(c.forward, c.up)) < 1e-12);
    const LocalFrame local = local_frame(view.eye);
    REQUIRE(glm::dot(c.forward, local.up) == Approx(std::sin(glm::radians(view.pitch_deg))).margin(1e-12));
  }
  ViewState east;
  east.heading_deg = 90;
  CHECK(glm::dot(camera_frame(east).forward, local_frame({0, 0}).east) == Approx(1));
  east.roll_deg = 90;  // the right wing points down
  CHECK(glm::dot(camera_frame(east).right, local_frame({0, 0}).up) == Approx(-1));
}

TEST_CASE("a tile's box holds every point of its surface between its heights") {
  Scene scene(3);
  for (int i = 0; i < 3000; ++i) {
    const TileId id = scene.tile(scene.place({-180, -90, 180, 90}));
    const double low = scene.between(-500, 8000), high = low + scene.between(0, 3000);
    const BoundingVolume volume = bounding_volume(tile_bounds(id), low, high, Occluder(-500));
    for (int j = 0; j < 30; ++j) {
      const glm::dvec3 point = to_geocentric(scene.place(tile_bounds(id)), scene.between(low, high));
      INFO(to_string(id));
      REQUIRE(in_box(volume, point));
      REQUIRE(volume.distance_m(point) == 0);
    }
  }
}

TEST_CASE("the box of a one-degree tile is hardly larger than the tile") {
  const BoundingVolume volume = bounding_volume({28, 36, 29, 37}, 0, 1000, Occluder(0));
  CHECK(2 * glm::length(volume.half_axes[0]) ==
        Approx(90163).epsilon(0.01));  // a degree of the 36th parallel
  CHECK(2 * glm::length(volume.half_axes[1]) == Approx(110970).epsilon(0.01));  // a degree of meridian there
  CHECK(2 * glm::length(volume.half_axes[2]) < 3000);  // the heights, and a kilometre and more of curvature
  CHECK(volume.distance_m(to_geocentric({28.5, 36.5}, 50000)) == Approx(49000).epsilon(0.01));
}

TEST_CASE("no tile that shows a point in the picture is culled") {
  Scene scene(4);
  int shown = 0, culled = 0;
  for (int i = 0; i < 20000; ++i) {
    const ViewState view = scene.view();
    const double lowest = scene.between(-500, 100);
    const Occluder occluder(lowest);
    const TileId id = scene.tile(i % 2 == 0 ? view.eye : scene.place({-180, -90, 180, 90}));
    const double low = scene.between(lowest, 5000), high = low + scene.between(0, 3000);
    const ViewFrustum volume(view, occluder);
    const bool seen = volume.sees(bounding_volume(tile_bounds(id), low, high, occluder));
    culled += !seen;
    for (int j = 0; j < 10; ++j) {
      const glm::dvec3 point = to_geocentric(scene.place(tile_bounds(id)), scene.between(low, high));
      if (!in_picture(view, point) || hidden_by_ellipsoid(volume.eye(), point, occluder.radii)) continue;
      ++shown;
      INFO(to_string(id));
      REQUIRE(seen);
    }
  }
  CHECK(shown > 5000);
  CHECK(culled > 5000);
}

TEST_CASE("small tiles beyond the horizon or behind the eye are culled") {
  const Occluder occluder(0);
  ViewState view;
  view.eye = {28.5, 36.5};
  view.height_m = 1000;  // the horizon is 113 km off, and a 1000 m hill can be seen at 226 km
  view.heading_deg = 90;
  const ViewFrustum volume(view, occluder);
  const auto tile = [&](double lon) {
    return bounding_volume(tile_bounds(tile_at({lon, 36.5}, 3)), 0, 1000, occluder);
  };
  CHECK(volume.sees(tile(29.5)));
  CHECK(volume.sees(tile(30.8)));
  CHECK_FALSE(volume.sees(tile(31.5)));
  CHECK_FALSE(volume.sees(tile(28.0)));
  CHECK_FALSE(volume.sees(tile(-151.5)));
}

}  // namespace cairn
