// What is drawn lies where GeographicLib projects it.

#include <algorithm>
#include <cmath>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "tests/support/gl_packs.h"
#include "tests/support/stage.h"
#include "tests/support/test_data.h"
#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

constexpr double kMetresPerDegree = 111195;

LonLat moved(LonLat place, double east_m, double north_m) {
  const double lat = place.lat + north_m / kMetresPerDegree;
  return {place.lon + east_m / kMetresPerDegree / std::cos(glm::radians(place.lat)), lat};
}

double distance_m(LonLat a, LonLat b) {
  return glm::length(to_geocentric(a, 0) - to_geocentric(b, 0));
}

/// The tiles around a place whose texels are at most this large, and all that are coarser.
std::vector<TileId> tiles_around_place(LonLat place, double texel_m, int least_finest) {
  std::vector<TileId> tiles;
  for (int level = kMinLevel; level <= kMaxLevel; ++level) {
    const TileId middle = tile_at(place, level);
    for (std::int32_t dy = -1; dy <= 1; ++dy) {
      for (std::int32_t dx = -1; dx <= 1; ++dx) {
        const TileId near = neighbour_of(middle, dx, dy);
        if (is_valid(near)) tiles.push_back(near);
      }
    }
    if (level >= least_finest && kMetresPerDegree * tile_width_degrees(level) / 256 <= texel_m) break;
  }
  return with_ancestors(tiles, kMinLevel);
}

/// A disc painted on the ground, as the picture has to show it.
struct Spot {
  double x = 0;  ///< its middle
  double y = 0;
  double west = 1e9, east = -1e9, top = 1e9, bottom = -1e9;  ///< what it reaches to
  int points = 0;

  void add(double at_x, double at_y, double weight, double& sum) {
    x += at_x * weight;
    y += at_y * weight;
    sum += weight;
    west = std::min(west, at_x), east = std::max(east, at_x);
    top = std::min(top, at_y), bottom = std::max(bottom, at_y);
    ++points;
  }
};

/// By projecting points of it, each as large as the picture shows it: the inverse cube of its depth.
Spot projected_disc(const ViewState& view, LonLat middle, double radius_m) {
  Spot spot;
  double sum = 0;
  for (int north = -10; north <= 10; ++north) {
    for (int east = -10; east <= 10; ++east) {
      if (east * east + north * north > 100) continue;
      const LonLat at = moved(middle, east * radius_m / 10, north * radius_m / 10);
      const PicturePoint point = project(view, to_geocentric(at, ridges_m(at)));
      spot.add(point.x, point.y, std::pow(point.depth_m, -3), sum);
    }
  }
  spot.x /= sum, spot.y /= sum;
  return spot;
}

/// The light pixels within a few of where they are expected.
Spot drawn_disc(const gl::Picture& picture, const Spot& expected) {
  Spot spot;
  double sum = 0;
  for (int row = static_cast<int>(expected.top) - 3; row <= static_cast<int>(expected.bottom) + 3; ++row) {
    for (int column = static_cast<int>(expected.west) - 3; column <= static_cast<int>(expected.east) + 3;
         ++column) {
      const double light = std::max(0, picture.pixel(column, row)[1] - 60);
      if (light > 0) spot.add(column + 0.5, row + 0.5, light, sum);
    }
  }
  if (sum > 0) spot.x /= sum, spot.y /= sum;
  return spot;
}

bool is_in_picture(const Spot& spot) {
  return spot.west > 4 && spot.top > 4 && spot.east < 156 && spot.bottom < 116;
}

}  // namespace

TEST_CASE("painted landmarks are drawn where GeographicLib projects them, from 20,000 km to 2 m") {
  struct Camera {
    double above_m;
    double pitch_deg;
  };
  const auto camera =
      GENERATE(Camera{2e7, -90}, Camera{1e6, -90}, Camera{30000, -75}, Camera{300, -70}, Camera{2, -85});
  const LonLat place{10.31, 45.72};
  ViewState view = view_at(place, 0, 20, camera.pitch_deg);
  const double footprint =
      pixel_footprint_m(view, camera.above_m / std::sin(glm::radians(-camera.pitch_deg)));
  // Around the place in the middle of the picture.
  const double ahead = camera.above_m / std::tan(glm::radians(-camera.pitch_deg));
  const LonLat middle =
      moved(place, ahead * std::sin(glm::radians(20.0)), ahead * std::cos(glm::radians(20.0)));
  const double apart = 18, radius = 4 * footprint;
  std::vector<LonLat> landmarks;
  for (const auto& [east, north] : {std::pair(0, 0), {1, 1}, {-1, 1}, {1, -1}, {-1, -1}}) {
    landmarks.push_back(moved(middle, east * apart * footprint, north * apart * footprint));
  }
  const auto colour = [&](LonLat at) -> std::array<std::uint8_t, 3> {
    const bool in = std::any_of(landmarks.begin(), landmarks.end(), [&](LonLat landmark) {
      return std::abs(at.lat - landmark.lat) * kMetresPerDegree < 5 * footprint &&
             distance_m(at, landmark) < radius;
    });
    return in ? std::array<std::uint8_t, 3>{255, 255, 255} : std::array<std::uint8_t, 3>{0, 0, 0};
  };
  const TempDir dir;
  const auto pack = dir.path() / "landmarks.cairn";
  const auto tiles = tiles_around_place(middle, footprint / 2, kRidgesFinest);
  write_coloured_pack(pack, tiles, TextureFormat::bc1, colour);

  Stage stage(pack);
  stage.look.fog = false;
  stage.look.to_sun = viewer::sun_direction(place, 12);
  view.height_m = ridges_m(place) + camera.above_m;
  stage.draw(view);
  const gl::Picture picture = stage.target().read();
  int in_picture = 0;
  for (const LonLat landmark : landmarks) {
    const Spot expected = projected_disc(view, landmark, radius);
    if (!is_in_picture(expected)) continue;
    const Spot drawn = drawn_disc(picture, expected);
    CAPTURE(camera.above_m, expected.x, expected.y, drawn.x, drawn.y);
    CHECK(drawn.points >= 15);
    CHECK(std::abs(drawn.x - expected.x) < 1);
    CHECK(std::abs(drawn.y - expected.y) < 1);
    ++in_picture;
  }
  CHECK(in_picture >= 3);
}

TEST_CASE("an aerial photo covers the ground that its file says, to the pixel") {
  const TempDir dir;
  const auto bare = dir.path() / "bare.cairn", clothed = dir.path() / "clothed.cairn";
  const std::string dem = "geotiff/swellendam_srtm_41_19_4326.tif";
  if (!bake_real_pack(bare, {dem})) return;
  bake_real_pack(clothed, {dem}, {"imagery/swellendam_3420B_2010_328_RGB_LATLNG.tif"});
  const GeoBounds photo{20.498877282221425, -34.07481658964323, 20.52630228152861, -33.998866591561885};
  ViewState view = view_at({20.512, -34.04}, 16000, 0, -90);
  // A sun six degrees high, so that the photo is seen, and what a filter mixes in across its edge is not.
  const LocalFrame ground = local_frame(view.eye);
  const glm::dvec3 to_sun = glm::normalize(ground.east + 0.1 * ground.up);

  gl::Picture without, with;
  std::vector<float> depth;
  {
    Stage stage(bare);
    stage.look.to_sun = to_sun;
    stage.draw(view);
    without = stage.target().read();
  }
  Stage stage(clothed);
  stage.look.to_sun = to_sun;
  stage.draw(view);
  with = stage.target().read();
  depth = stage.target().read_depth();
  const double pixel = pixel_footprint_m(view, 16000) / kMetresPerDegree;
  int inside = 0, inside_changed = 0, outside = 0, outside_changed = 0;
  for (int row = 0; row < with.height; ++row) {
    for (int column = 0; column < with.width; ++column) {
      const double d = static_cast<double>(depth[static_cast<std::size_t>(row * with.width + column)]);
      const LonLat at = to_geodetic(shown_at(view, column + 0.5, row + 0.5, d)).place;
      const double narrow = std::cos(glm::radians(at.lat));
      const double within = std::min({(at.lon - photo.west) * narrow, (photo.east - at.lon) * narrow,
                                      at.lat - photo.south, photo.north - at.lat}) /
                            pixel;
      const std::uint8_t* a = without.pixel(column, row);
      const std::uint8_t* b = with.pixel(column, row);
      const bool changed = std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]) > 6;
      inside += within > 1;
      inside_changed += within > 1 && changed;
      outside += within < -1;
      outside_changed += within < -1 && changed;
    }
  }
  CHECK(inside > 500);
  CHECK(inside_changed > 0.98 * inside);
  CHECK(outside > 10000);
  CHECK(outside_changed == 0);
}

TEST_CASE("smooth imagery of the whole Earth is smooth in the picture, from any side") {
  const TempDir dir;
  const auto pack = dir.path() / "smooth.cairn";
  std::vector<TileId> tiles;
  for (std::int32_t y = 0; y < tiles_pole_to_pole(-5); ++y) {
    for (std::int32_t x = 0; x < tiles_around(-5); ++x) tiles.push_back({-5, x, y});
  }
  write_coloured_pack(
      pack, with_ancestors(tiles, kMinLevel), TextureFormat::bc1,
      [](LonLat at) -> std::array<std::uint8_t, 3> {
        const double angle = glm::radians(at.lon), lat = glm::radians(at.lat);
        const auto byte = [](double v) { return static_cast<std::uint8_t>(std::lround(140 + 50 * v)); };
        return {byte(std::cos(angle) * std::cos(lat)), byte(std::sin(angle) * std::cos(lat)),
                byte(std::sin(lat))};
      },
      Layers::imagery);
  Stage stage(pack, 320, 240);
  stage.look.fog = false;
  for (const LonLat eye : {LonLat{0, 20}, {100, -50}, {180, 0}, {-90, 89}, {30, -90}}) {
    for (const double height : {2.2e7, 9e6, 1e6}) {
      ViewState view = view_at(eye, height, 10, -90);
      view.viewport_width_px = 320;
      view.viewport_height_px = 240;
      stage.look.to_sun = glm::normalize(to_geocentric(eye, 0));
      stage.draw(view);
      const gl::Picture picture = stage.target().read();
      int rough = 0;
      for (int row = 1; row < picture.height; ++row) {
        for (int column = 1; column < picture.width; ++column) {
          const double from_middle = std::hypot(column - 160, row - 120);
          const double radius = 240 / 2.0 / std::tan(glm::radians(22.5)) *
                                std::tan(std::asin(std::min(0.99, 6.37e6 / (6.37e6 + height))));
          if (from_middle > 0.93 * radius) continue;
          for (int c = 0; c < 3; ++c) {
            const int here = picture.pixel(column, row)[c];
            rough += std::abs(here - picture.pixel(column - 1, row)[c]) > 12;
            rough += std::abs(here - picture.pixel(column, row - 1)[c]) > 12;
          }
        }
      }
      CAPTURE(eye.lon, eye.lat, height);
      CHECK(rough == 0);
    }
  }
}

}  // namespace cairn::test
