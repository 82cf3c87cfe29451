#include "builder/resample/resample_projected.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <span>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

struct Case {
  const char* name;
  Georeference georeference;
  double samples_per_degree;
  LonLat middle;
};

/// The azimuthal equidistant plane around the north pole of a sphere, in degrees.
class PolarPlane final : public CrsTransform {
 public:
  void to_degrees(std::span<LonLat> places) const override {
    for (LonLat& p : places) p = {std::atan2(p.lon, -p.lat) * 180 / M_PI, 90 - std::hypot(p.lon, p.lat)};
  }
  void from_degrees(std::span<LonLat> places) const override {
    for (LonLat& p : places) {
      const double away = 90 - p.lat, lon = p.lon * M_PI / 180;
      p = {away * std::sin(lon), -away * std::cos(lon)};
    }
  }
};

// Grids turned against the meridians by up to 3°, and densities from 1.04 samples a post.
std::vector<Case> cases() {
  using Crs = Georeference::Crs;
  return {{"UTM 11N 30 m", {Crs::utm, 11, true, 376328.7, 3807902.8, 30, -30}, 4096, {-118.1, 34.3}},
          {"UTM 32N at the zone's edge", {Crs::utm, 32, true, 710000, 6660000, 90, -90}, 2048, {12.8, 60.01}},
          {"UTM 1S across the antimeridian",
           {Crs::utm, 1, false, 166000, 8200000, 40, -40},
           4096,
           {-180.01, -16.3}},
          {"UTM 32N, rows northwards", {Crs::utm, 32, true, 600000, 0, 92.45, 92.45}, 1280, {10.2, 0.6}},
          {"Web Mercator", {Crs::web_mercator, 0, true, 1.1e6, 5.9e6, 152.87, -152.87}, 2048, {10.6, 46.8}},
          {"geographic", {Crs::geographic, 0, true, 8, 47, 1 / 1200.0, -1 / 1200.0}, 2048, {8.5, 46.5}}};
}

float rugged(std::int64_t column, std::int64_t row) {
  const auto u = static_cast<double>(column);
  const auto v = static_cast<double>(row);
  const double noise = std::fmod(std::abs(std::sin(u * 12.9898 + v * 78.233) * 43758.5453), 1.0);
  return static_cast<float>(2500 + 900 * std::sin(u / 31) * std::cos(v / 23) + 200 * std::sin((u - v) / 3) +
                            60 * noise);
}

IndexWindow window_at(const Case& c, std::int64_t side) {
  const auto x = static_cast<std::int64_t>((c.middle.lon + 180) * c.samples_per_degree);
  const auto y = static_cast<std::int64_t>((c.middle.lat + 90) * c.samples_per_degree);
  return {{x, x + side - 1}, {y, y + side - 1}};
}

using Height = std::function<float(std::int64_t, std::int64_t)>;

std::vector<float> heights_of(IndexWindow posts, const Height& height) {
  std::vector<float> heights;
  for (std::int64_t row = posts.y.first; row <= posts.y.last; ++row) {
    for (std::int64_t column = posts.x.first; column <= posts.x.last; ++column)
      heights.push_back(height(column, row));
  }
  return heights;
}

// Of a raster that goes on far beyond the window.
ProjectedResampler resampler_of(const Case& c) {
  const auto middle = c.georeference.post_at(c.middle);
  const auto column = static_cast<std::int64_t>(middle.column), row = static_cast<std::int64_t>(middle.row);
  return {c.georeference, {{column - 1000, column + 1000}, {row - 1000, row + 1000}}, c.samples_per_degree};
}

std::vector<float> resampled(const Case& c, IndexWindow window, const Height& height, double tolerance) {
  const ProjectedResampler resampler = resampler_of(c);
  std::vector<float> out(static_cast<std::size_t>(window.count()));
  const SamplePositions positions = resampler.positions_of(window);
  const std::vector<float> heights = heights_of(positions.posts, height);
  const std::vector<std::uint8_t> fitted(heights.size(), 1);
  const auto fit = resampler.resample(heights, fitted, {}, positions, {0, tolerance}, out, {});
  CHECK(fit.worst_residual_m <= tolerance);
  return out;
}

// The largest error at posts whose square lies in the window, by the projection itself.
double worst_post_error(const Case& c, IndexWindow window, const std::vector<float>& samples,
                        const Height& height, int& met) {
  const IndexWindow posts = resampler_of(c).positions_of(window).posts;
  double worst = 0;
  for (std::int64_t row = posts.y.first; row <= posts.y.last; ++row) {
    for (std::int64_t column = posts.x.first; column <= posts.x.last; ++column) {
      const LonLat place = c.georeference.place_of(static_cast<double>(column), static_cast<double>(row));
      const double x = (place.lon + 180) * c.samples_per_degree;
      const double y = (place.lat + 90) * c.samples_per_degree;
      const auto i = static_cast<std::int64_t>(std::floor(x));
      const auto j = static_cast<std::int64_t>(std::floor(y));
      if (!window.x.holds({i, i + 1}) || !window.y.holds({j, j + 1})) continue;
      const auto at = [&](std::int64_t dx, std::int64_t dy) {
        return static_cast<double>(samples[window.offset(i + dx, j + dy)]);
      };
      const double s = x - std::floor(x);
      const double t = y - std::floor(y);
      const double surface =
          (1 - t) * ((1 - s) * at(0, 0) + s * at(1, 0)) + t * ((1 - s) * at(0, 1) + s * at(1, 1));
      worst = std::max(worst, std::abs(surface - static_cast<double>(height(column, row))));
      ++met;
    }
  }
  return worst;
}

}  // namespace

TEST_CASE("the surface meets every post of a projected raster within the tolerance") {
  for (const Case& c : cases()) {
    for (double tolerance : {0.05, 0.002}) {
      CAPTURE(c.name, tolerance);
      const IndexWindow window = window_at(c, 200);
      CHECK(resampler_of(c).is_well_conditioned());
      int met = 0;
      const auto samples = resampled(c, window, rugged, tolerance);
      // Places come from a mesh that is good to 1e-4 post, on slopes of 300 m a post.
      CHECK(worst_post_error(c, window, samples, rugged, met) < tolerance + 0.01);
      CHECK(met > 5000);
    }
  }
}

TEST_CASE("overlapping windows of a projected raster agree inside their halos within the tolerance") {
  constexpr double tolerance = 0.005;
  constexpr std::int64_t halo = ProjectedResampler::kHalo;
  for (const Case& c : cases()) {
    const IndexWindow west = window_at(c, 160);
    IndexWindow east = west;
    east.x = {west.x.last - 2 * halo, west.x.last + 120};
    const auto a = resampled(c, west, rugged, tolerance);
    const auto b = resampled(c, east, rugged, tolerance);
    double worst = 0;
    const std::int64_t x = west.x.last - halo;
    for (std::int64_t y = west.y.first + halo; y <= west.y.last - halo; ++y) {
      worst = std::max(worst, std::abs(static_cast<double>(a[west.offset(x, y)] - b[east.offset(x, y)])));
    }
    CAPTURE(c.name);
    CHECK(worst < 3 * tolerance);
  }
}

TEST_CASE("a constant raster stays constant on any grid") {
  for (const Case& c : cases()) {
    for (float h : resampled(
             c, window_at(c, 90), [](std::int64_t, std::int64_t) { return 4321.5f; }, 1e-3)) {
      REQUIRE(h == Approx(4321.5f).margin(1e-3));
    }
  }
}

TEST_CASE("posts a degree are counted along the closer axis, and too coarse a level is told") {
  const Georeference utm{Georeference::Crs::utm, 11, true, 376328.7, 3807902.8, 30, -30};
  const IndexWindow posts{{0, 1196}, {0, 642}};
  CHECK(posts_per_degree(utm, posts) == Approx(3697).margin(5));  // 30 m of latitude at 34° N
  CHECK(ProjectedResampler(utm, posts, 4096).is_well_conditioned());
  CHECK_FALSE(ProjectedResampler(utm, posts, 3700).is_well_conditioned());
  const Georeference degrees{Georeference::Crs::geographic, 0, true, 8, 47, 1 / 1200.0, -1 / 600.0};
  CHECK(posts_per_degree(degrees, posts) == Approx(1200));
}

TEST_CASE("around a pole, wherever it lies among the posts, their density is that along its meridians") {
  Georeference polar{Georeference::Crs::other, 0, true, 0, 0, 1 / 500.0, -1 / 500.0};
  polar.transform = std::make_shared<PolarPlane>();
  for (const auto& [column, row] : {std::pair{22.5, 28.5}, {3.0, 40.25}, {-5.5, 17.5}}) {
    CAPTURE(column, row);
    polar.x0 = -column / 500;
    polar.y0 = row / 500;
    CHECK(posts_per_degree(polar, {{0, 47}, {0, 47}}) == Approx(500));
  }
}

}  // namespace cairn
