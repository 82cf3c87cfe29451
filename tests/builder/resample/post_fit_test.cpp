#include "builder/resample/post_fit.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

constexpr std::int64_t kSide = 12;

struct Post {
  std::int64_t x, y;
  double s, t;
  float height;

  std::array<double, kSide * kSide> row() const {
    std::array<double, kSide * kSide> a{};
    const auto corner = static_cast<std::size_t>(y * kSide + x);
    a[corner] = (1 - s) * (1 - t);
    a[corner + 1] = s * (1 - t);
    a[corner + kSide] = (1 - s) * t;
    a[corner + kSide + 1] = s * t;
    return a;
  }
};

std::vector<Post> scattered_posts(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<Post> posts;
  for (std::int64_t y = 0; y < kSide - 1; ++y) {
    for (std::int64_t x = 0; x < kSide - 1; ++x) {
      if (unit(random) > 0.6) continue;
      posts.push_back({x, y, unit(random), unit(random), static_cast<float>(1000 * unit(random))});
    }
  }
  return posts;
}

// A·Aᵀ·λ = H - A·G by elimination with pivoting, then G + Aᵀ·λ.
std::vector<double> least_change(const std::vector<Post>& posts, const std::vector<float>& g) {
  const std::size_t n = posts.size();
  std::vector<std::vector<double>> m(n, std::vector<double>(n + 1));
  for (std::size_t i = 0; i < n; ++i) {
    const auto a = posts[i].row();
    for (std::size_t k = 0; k < n; ++k) {
      const auto b = posts[k].row();
      for (std::size_t s = 0; s < a.size(); ++s) m[i][k] += a[s] * b[s];
    }
    m[i][n] = static_cast<double>(posts[i].height);
    for (std::size_t s = 0; s < a.size(); ++s) m[i][n] -= a[s] * static_cast<double>(g[s]);
  }
  for (std::size_t p = 0; p < n; ++p) {
    std::size_t best = p;
    for (std::size_t i = p; i < n; ++i) best = std::abs(m[i][p]) > std::abs(m[best][p]) ? i : best;
    std::swap(m[p], m[best]);
    for (std::size_t i = 0; i < n; ++i) {
      if (i == p) continue;
      const double f = m[i][p] / m[p][p];
      for (std::size_t k = p; k <= n; ++k) m[i][k] -= f * m[p][k];
    }
  }
  std::vector<double> result(g.begin(), g.end());
  for (std::size_t i = 0; i < n; ++i) {
    const auto a = posts[i].row();
    for (std::size_t s = 0; s < a.size(); ++s) result[s] += a[s] * m[i][n] / m[i][i];
  }
  return result;
}

}  // namespace

TEST_CASE("the fit is the least change of the samples: a dense solve agrees") {
  for (unsigned seed : {1u, 2u, 3u}) {
    const std::vector<Post> posts = scattered_posts(seed);
    PostEquations equations(kSide);
    for (const Post& p : posts) equations.add(p.y * kSide + p.x, p.s, p.t, p.height);
    REQUIRE(equations.size() == posts.size());
    std::vector<float> samples(kSide * kSide, 500);
    const std::vector<double> expected = least_change(posts, samples);
    const PostEquations::Fit fit = equations.fit(samples, {0, 1e-3});
    CHECK(fit.worst_residual_m <= 1e-3);
    CHECK(fit.rounds > 1);
    for (std::size_t i = 0; i < samples.size(); ++i) {
      CHECK(static_cast<double>(samples[i]) == Approx(expected[i]).margin(0.02));
    }
  }
}

TEST_CASE("the residual that a fit reports is that of its samples") {
  const std::vector<Post> posts = scattered_posts(8);
  PostEquations equations(kSide);
  for (const Post& p : posts) equations.add(p.y * kSide + p.x, p.s, p.t, p.height);
  for (double tolerance : {1e9, 10.0, 0.1, 0.002}) {
    std::vector<float> samples(kSide * kSide, 300);
    const PostEquations::Fit fit = equations.fit(samples, {0, tolerance});
    double worst = 0;
    for (const Post& p : posts) {
      const auto a = p.row();
      double surface = 0;
      for (std::size_t s = 0; s < a.size(); ++s) surface += a[s] * static_cast<double>(samples[s]);
      worst = std::max(worst, std::abs(surface - static_cast<double>(p.height)));
    }
    CHECK(fit.worst_residual_m == Approx(worst).margin(2e-4));
    CHECK(fit.worst_residual_m <= tolerance);
    CHECK((fit.rounds == 0) == (tolerance == 1e9));
  }
}

TEST_CASE("with an interval a fit misses posts by no more, and leaves a surface within it alone") {
  const std::vector<Post> posts = scattered_posts(5);
  PostEquations equations(kSide);
  for (const Post& p : posts) equations.add(p.y * kSide + p.x, p.s, p.t, p.height);
  const std::vector<float> before(kSide * kSide, 500);
  std::vector<float> samples(before);
  constexpr double interval = 120, tolerance = 0.01;
  const PostEquations::Fit fit = equations.fit(samples, {interval, tolerance});
  CHECK(fit.worst_residual_m <= tolerance);
  for (const Post& p : posts) {
    const auto a = p.row();
    double surface = 0;
    for (std::size_t s = 0; s < a.size(); ++s) surface += a[s] * static_cast<double>(samples[s]);
    const double height = static_cast<double>(p.height);
    // What was missed by more than the interval is missed by the interval, the rest by as much as before.
    const double expected = height + std::clamp(500 - height, -interval, interval);
    CHECK(surface == Approx(expected).margin(2 * tolerance));
  }
  std::vector<float> within(before);
  CHECK(equations.fit(within, {600, tolerance}).rounds == 0);
  CHECK(within == before);
}

TEST_CASE("posts that contradict each other end the fit, and it says so") {
  PostEquations equations(2);
  equations.add(0, 0.5, 0.5, 100);
  equations.add(0, 0.5, 0.5, 200);
  std::vector<float> samples(4, 0);
  const PostEquations::Fit fit = equations.fit(samples, {0, 0.01});
  CHECK(fit.worst_residual_m > 49.9);
  for (float h : samples) CHECK(std::isfinite(h));
}

}  // namespace cairn
