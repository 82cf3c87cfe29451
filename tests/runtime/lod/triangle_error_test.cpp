// TriangleError::exceeds() compared with every sample that a triangle covers, projected from angles.

#include "runtime/lod/mesh/triangle_error.h"

#include <cmath>
#include <optional>
#include <random>

#include <catch2/catch.hpp>
#include <glm/trigonometric.hpp>

#include "cairn/geodesy.h"
#include "tests/support/test_pack.h"

namespace cairn::test {
namespace {

constexpr int kSize = 65;
constexpr double kQuantum_m = 0.25;

using Triangle = SampleTriangle;

/// Returns pixels from the middle of the viewport; nullopt outside it and behind the camera.
std::optional<glm::dvec2> pixel(const ViewState& view, const glm::dvec3& point, bool only_inside) {
  const CameraFrame camera = camera_frame(view);
  const glm::dvec3 to = point - camera.position;
  if (glm::dot(to, camera.forward) <= 0.01) return std::nullopt;
  const double off_axis =
      std::atan2(glm::length(glm::cross(to, camera.forward)), glm::dot(to, camera.forward));
  const double around = std::atan2(glm::dot(to, camera.up), glm::dot(to, camera.right));
  const double focal = view.viewport_height_px / 2.0 / std::tan(glm::radians(view.fov_y_deg / 2));
  const glm::dvec2 at = focal * std::tan(off_axis) * glm::dvec2(std::cos(around), std::sin(around));
  const bool inside =
      std::abs(at.x) <= view.viewport_width_px / 2.0 && std::abs(at.y) <= view.viewport_height_px / 2.0;
  return inside || !only_inside ? std::optional(at) : std::nullopt;
}

/// Halves the tile's square at random: a triangle of the bisection hierarchy.
Triangle random_triangle(const TileId& id, std::mt19937& random) {
  const int n = kSize - 1;
  const std::array<SampleAddress, 4> c{{{0, 0}, {n, 0}, {n, n}, {0, n}}};
  const std::size_t first =
      ((id.x ^ id.y) & 1) == 0 ? 1 : 0;  // the right angle's corner, or the opposite one
  const std::size_t right = first + 2 * (random() % 2);
  Triangle t{c[(right + 1) % 4], c[(right + 3) % 4], c[right]};
  for (int halvings = static_cast<int>(random() % 12); halvings > 0; --halvings) {
    const SampleAddress m{(t[0][0] + t[1][0]) / 2, (t[0][1] + t[1][1]) / 2};
    t = random() % 2 == 0 ? Triangle{t[2], t[0], m} : Triangle{t[1], t[2], m};
  }
  return t;
}

double area(const std::array<double, 2>& a, const std::array<double, 2>& b, const std::array<double, 2>& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// A tile, and the finest samples under it: `ratio` along each of its cells.
struct Ground {
  int relief = 1;
  TileId id;
  HeightTile heights;
  int ratio = 1;
  double error_m = 0;

  std::int32_t finest_quanta(int column, int row) const {
    const std::int64_t n = kSize - 1;
    return relief * hills(id.x * n * ratio + column, id.y * n * ratio + row);
  }
  double finest_m(int column, int row) const { return finest_quanta(column, row) * kQuantum_m; }
  double bilinear_m(int column, int row) const {
    const int c = std::min(column / ratio, kSize - 2), r = std::min(row / ratio, kSize - 2);
    const double u = static_cast<double>(column) / ratio - c, v = static_cast<double>(row) / ratio - r;
    const auto h = [&](int x, int y) { return heights.at(x, y) * kQuantum_m; };
    return (1 - v) * ((1 - u) * h(c, r) + u * h(c + 1, r)) +
           v * ((1 - u) * h(c, r + 1) + u * h(c + 1, r + 1));
  }
  glm::dvec3 place(double column, double row, double height_m) const {
    const double cell = tile_width_degrees(id.level) / (kSize - 1) / ratio;
    const double width = tile_width_degrees(id.level);
    return to_geocentric(LonLat{id.x * width - 180 + column * cell, id.y * width - 90 + row * cell},
                         height_m);
  }
};

Ground ground(LonLat at, int level, int finest, int relief) {
  Ground g;
  g.relief = relief;
  g.id = tile_at(at, level);
  g.ratio = 1 << (finest - level);
  g.heights.size = kSize;
  for (int row = 0; row < kSize; ++row) {
    for (int column = 0; column < kSize; ++column)
      g.heights.samples.push_back(g.finest_quanta(column * g.ratio, row * g.ratio));
  }
  if (g.ratio == 1) return g;
  for (int row = 0; row <= (kSize - 1) * g.ratio; ++row) {
    for (int column = 0; column <= (kSize - 1) * g.ratio; ++column)
      g.error_m = std::max(g.error_m, std::abs(g.finest_m(column, row) - g.bilinear_m(column, row)));
  }
  g.error_m = std::max(g.error_m, 1e-3);  // so that what is between the samples counts
  return g;
}

LodScene scene_of(const Ground& g) {
  LodTile tile;
  tile.area = tile.source = g.id;
  tile.heights = std::make_shared<const HeightTile>(g.heights);
  const auto [low, high] = std::minmax_element(g.heights.samples.begin(), g.heights.samples.end());
  tile.min_m = *low * kQuantum_m - g.error_m, tile.max_m = *high * kQuantum_m + g.error_m;
  tile.error_m = g.error_m;
  return {kSize, kQuantum_m, tile.min_m, {tile}};
}

/// The largest of screen error less what is allowed there (nothing, if the tolerance is 0), over all finest
/// samples that the triangle covers.
double most_over_px(const Ground& g, const LodView& view, const Triangle& t) {
  std::array<std::array<double, 2>, 3> at;
  std::array<glm::dvec3, 3> corner;
  for (std::size_t i = 0; i < 3; ++i) {
    at[i] = {static_cast<double>(t[i][0] * g.ratio), static_cast<double>(t[i][1] * g.ratio)};
    corner[i] = g.place(at[i][0], at[i][1], g.heights.at(t[i][0], t[i][1]) * kQuantum_m);
  }
  double most = -HUGE_VAL;
  for (int row = 0; row <= (kSize - 1) * g.ratio; ++row) {
    for (int column = 0; column <= (kSize - 1) * g.ratio; ++column) {
      const std::array<double, 2> p{static_cast<double>(column), static_cast<double>(row)};
      const double whole = area(at[0], at[1], at[2]), a = area(p, at[1], at[2]) / whole,
                   b = area(at[0], p, at[2]) / whole, c = area(at[0], at[1], p) / whole;
      if (a < 0 || b < 0 || c < 0) continue;
      const double height_m = g.finest_m(column, row);
      const glm::dvec3 truth = g.place(column, row, height_m);
      const auto is = pixel(view.view, truth, true);
      // What the Earth hides is not in the picture; from above its lowest place that is what is beyond 90°.
      const glm::dvec3 up = glm::normalize(truth - g.place(column, row, height_m - 1000));
      if (!is || glm::dot(camera_frame(view.view).position - truth, up) < 0) continue;
      const auto drawn = pixel(view.view, a * corner[0] + b * corner[1] + c * corner[2], false);
      if (!drawn) return HUGE_VAL;
      double allowed = view.tolerance_px;
      if (g.error_m > 0 && view.tolerance_px > 0) {
        // Three quarters of the tolerance for the tile, or its own error and a quarter.
        double tile_px = 0;
        for (const double sign : {-1.0, 1.0}) {
          const auto moved = pixel(view.view, g.place(column, row, height_m + sign * g.error_m), false);
          if (!moved)
            tile_px = HUGE_VAL;
          else
            tile_px = std::max(tile_px, glm::distance(*moved, *is));
        }
        allowed = std::max(allowed, 1.05 * tile_px + view.tolerance_px / 4);
      }
      most = std::max(most, glm::distance(*drawn, *is) - allowed);
    }
  }
  return most;
}

ViewState random_view(const Ground& g, std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const GeoBounds area = tile_bounds(g.id);
  ViewState view;
  view.eye = {between(area.west - 1, area.east + 1),
              std::clamp(between(area.south - 1, area.north + 1), -90.0, 90.0)};
  view.height_m = 700 + std::pow(10.0, between(1, 7.3));
  view.heading_deg = between(0, 360);
  view.pitch_deg = view.height_m > 1e6 ? between(-90, -60) : between(-90, 5);
  view.roll_deg = between(-30, 30);
  view.fov_y_deg = between(20, 90);
  view.viewport_width_px = 1280;
  view.viewport_height_px = 720;
  return view;
}

/// Checks triangles of a tile of `level` whose finest samples are those of `finest`. Tolerances are about the
/// triangles' own errors, so that a bound that is a little too small shows.
void check(int level, int finest, int rounds) {
  constexpr LonLat kPlaces[] = {{7.6, 46.2},    {179.9, -16.3}, {12.3, 85.9},
                                {-70.4, -89.9}, {0.1, 0.1},     {30, 75}};
  std::mt19937 random(5);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  int within = 0, exceeding = 0, visible = 0;
  for (const LonLat& place : kPlaces) {
    for (const int relief : {0, 1, 8}) {
      const Ground g = ground(place, level, finest, relief);
      const LodScene scene = scene_of(g);
      const SquareErrors errors(scene, scene.tiles[0], g.error_m > 0);
      const SubtriangleErrorRanges ranges(g.heights, g.id, kQuantum_m, g.error_m > 0);
      for (int i = 0; i < rounds; ++i) {
        LodView view{random_view(g, random), 0, true};
        const Triangle t = random_triangle(g.id, random);
        const double off_px = most_over_px(g, view, t);
        view.tolerance_px = off_px > 0 && off_px < 1e6 ? off_px * between(0.7, 1.8) : 1;
        const double over = most_over_px(g, view, t);
        const TriangleError error(view, scene.lowest_m);
        const bool exceeds = error.exceeds({g.heights, kQuantum_m, errors, ranges, g.error_m}, t);
        CAPTURE(place.lon, place.lat, relief, i, view.tolerance_px, off_px, t[0], t[1], t[2]);
        if (!exceeds) CHECK(over <= 1e-6 * (1 + view.tolerance_px));
        if (over == -HUGE_VAL) continue;
        ++visible;
        ++(exceeds ? exceeding : within);
      }
    }
  }
  // Neither answer is rare, so that both were checked.
  CAPTURE(visible, within, exceeding);
  CHECK(visible > rounds);
  CHECK(within > visible / 10);
  CHECK(exceeding > visible / 10);
}

TEST_CASE("A triangle that TriangleError finds within the tolerance has no sample farther off", "[slow]") {
  check(3, 3, 200);
  check(0, 0, 200);
  check(-4, -4, 200);
}

TEST_CASE(
    "A triangle that TriangleError finds within the tolerance has no finer sample farther off than the "
    "tile's error adds",
    "[slow]") {
  check(1, 3, 20);
  check(-4, -2, 20);
}

}  // namespace
}  // namespace cairn::test
