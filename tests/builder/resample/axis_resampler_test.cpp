#include "builder/resample/axis_resampler.h"

#include <cmath>
#include <limits>
#include <map>
#include <random>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

struct Grids {
  LatticeAxis axis;
  double samples_per_degree;
};

std::vector<Grids> grids() {
  std::vector<Grids> all = {{{1200, 0}, 2048},        {{3600, 0}, 4096},      {{1200, 0}, 1280},
                            {{1201, 0}, 2048},        {{600, 0}, 2048},       {{12, 0}, 16},
                            {{4096, 0}, 4096},        {{1200, 0.5}, 2048},    {{3600, 0.5}, 4096},
                            {{1192.137, 0.37}, 2048}, {{12, 0}, 2048},        {{1024, 0.25}, 2048},
                            {{1024, 0}, 2048},        {{1, 0.5}, 512},        {{0.4, 0}, 1},
                            {{1200, 0}, 4096},        {{7919.3, 0.999}, 8192}};
  std::mt19937 random(11);
  std::uniform_real_distribution<double> ratio(1.04, 3), phase(0, 1);
  for (int i = 0; i < 40; ++i) all.push_back({{4096 / ratio(random), phase(random)}, 4096});
  return all;
}

// The interpolant of the samples at a post, as weights of the posts.
std::map<std::int64_t, double> surface_at(const AxisWeights& w, double position) {
  const auto j = static_cast<std::int64_t>(std::floor(position));
  const double t = position - std::floor(position);
  std::map<std::int64_t, double> sum;
  for (int side = 0; side < 2; ++side) {
    if (side == 1 && t == 0) break;
    const auto& row = w.rows[static_cast<std::size_t>(j + side - w.samples.first)];
    const auto weights = w.weights_of(row);
    for (std::size_t c = 0; c < weights.size(); ++c) {
      sum[row.first + static_cast<std::int64_t>(c)] += (side == 0 ? 1 - t : t) * weights[c];
    }
  }
  return sum;
}

bool same_rows(const AxisWeights& a, const AxisWeights& b, std::int64_t sample) {
  const auto& x = a.rows[static_cast<std::size_t>(sample - a.samples.first)];
  const auto& y = b.rows[static_cast<std::size_t>(sample - b.samples.first)];
  const auto wx = a.weights_of(x);
  const auto wy = b.weights_of(y);
  return x.first == y.first && std::equal(wx.begin(), wx.end(), wy.begin(), wy.end());
}

}  // namespace

TEST_CASE("the exact samples' linear surface gives every post back") {
  for (const Grids& g : grids()) {
    CAPTURE(g.axis.posts_per_degree, g.axis.phase, g.samples_per_degree);
    const AxisResampler axis(g.axis, g.samples_per_degree, ResampleMethod::exact);
    REQUIRE(axis.is_well_conditioned());
    const AxisPositions positions(g.axis, g.samples_per_degree);
    const auto middle = static_cast<std::int64_t>(g.samples_per_degree * 207.3);
    const AxisWeights w = axis.weights_for({middle, middle + 600});
    const std::int64_t first = positions.first_post_from(middle);
    for (std::int64_t i = first; positions.position(i) < static_cast<double>(middle + 600); ++i) {
      for (const auto& [post, weight] : surface_at(w, positions.position(i))) {
        REQUIRE(weight == Approx(post == i ? 1.0 : 0.0).margin(1e-9));
      }
    }
  }
}

TEST_CASE("a sample's weights are the same bits in every window, and its posts those that were announced") {
  std::mt19937 random(5);
  for (const Grids& g : grids()) {
    CAPTURE(g.axis.posts_per_degree, g.axis.phase, g.samples_per_degree);
    for (ResampleMethod method :
         {ResampleMethod::nearest, ResampleMethod::bilinear, ResampleMethod::cubic, ResampleMethod::exact}) {
      const AxisResampler axis(g.axis, g.samples_per_degree, method);
      const auto middle = static_cast<std::int64_t>(g.samples_per_degree * 161.7);
      const AxisWeights whole = axis.weights_for({middle, middle + 300});
      for (int i = 0; i < 30; ++i) {
        const auto first = middle + std::uniform_int_distribution<std::int64_t>(0, 300)(random);
        const auto last = std::uniform_int_distribution<std::int64_t>(first, middle + 300)(random);
        const AxisWeights part = axis.weights_for({first, last});
        REQUIRE(part.rows.size() == static_cast<std::size_t>(last - first + 1));
        const IndexRange posts = axis.posts_for({first, last});
        std::int64_t least = posts.last;
        std::int64_t most = posts.first;
        for (std::int64_t k = first; k <= last; ++k) {
          REQUIRE(same_rows(whole, part, k));
          const auto& row = part.rows[static_cast<std::size_t>(k - first)];
          least = std::min(least, row.first);
          most = std::max(most, row.first + row.count - 1);
        }
        REQUIRE(posts == IndexRange{least, most});
      }
    }
  }
}

TEST_CASE("constants and planes come out as they went in, whatever the method") {
  for (const Grids& g : grids()) {
    for (ResampleMethod method : {ResampleMethod::bilinear, ResampleMethod::cubic, ResampleMethod::exact}) {
      const AxisResampler axis(g.axis, g.samples_per_degree, method);
      const double ratio = g.samples_per_degree / g.axis.posts_per_degree;
      const AxisWeights w = axis.weights_for({5000, 5300});
      for (std::int64_t k = 5000; k <= 5300; ++k) {
        const auto& row = w.rows[static_cast<std::size_t>(k - 5000)];
        double ones = 0;
        double place = 0;
        for (std::size_t c = 0; c < w.weights_of(row).size(); ++c) {
          ones += w.weights_of(row)[c];
          const auto post = static_cast<double>(row.first + static_cast<std::int64_t>(c));
          place += w.weights_of(row)[c] * ((post + g.axis.phase) * ratio - static_cast<double>(k));
        }
        REQUIRE(ones == Approx(1).margin(1e-12));
        REQUIRE(place == Approx(0).margin(2e-6));  // a post within 1e-6 of a sample is taken to lie on it
      }
    }
  }
}

TEST_CASE("the correction is the smallest one: a dense least-norm solve over many posts agrees") {
  // Oracle: G = G0 + Aᵀ(AAᵀ)⁻¹(H - A·G0) over 60 posts at once, by dense elimination, in long double.
  for (const Grids& g : {Grids{{3600, 0}, 4096}, Grids{{1200, 0.5}, 2048}, Grids{{1192.137, 0.37}, 2048}}) {
    const AxisPositions at(g.axis, g.samples_per_degree);
    const std::int64_t first = 1000;
    const std::size_t n = 60;
    const std::int64_t s0 = at.interval_of(first);
    const auto samples = static_cast<std::size_t>(at.interval_of(first + 59) + 2 - s0);
    std::mt19937 random(2);
    std::vector<double> posts(n + 10);
    for (double& h : posts) h = std::uniform_real_distribution<double>(0, 100)(random);
    const auto evaluate = [&](ResampleMethod method) {
      const AxisWeights w = AxisResampler(g.axis, g.samples_per_degree, method)
                                .weights_for({s0, s0 + static_cast<std::int64_t>(samples) - 1});
      std::vector<long double> out(samples);
      for (std::size_t k = 0; k < samples; ++k) {
        const auto weights = w.weights_of(w.rows[k]);
        for (std::size_t c = 0; c < weights.size(); ++c) {
          const std::int64_t p = w.rows[k].first + static_cast<std::int64_t>(c) - first + 5;
          const auto clamped = static_cast<std::size_t>(std::clamp<std::int64_t>(p, 0, 69));
          out[k] += static_cast<long double>(weights[c]) * posts[clamped];
        }
      }
      return out;
    };
    std::vector<long double> dense = evaluate(ResampleMethod::cubic);
    std::vector<std::vector<long double>> a(n, std::vector<long double>(samples));
    for (std::size_t i = 0; i < n; ++i) {
      const auto post = first + static_cast<std::int64_t>(i);
      const auto j = static_cast<std::size_t>(at.interval_of(post) - s0);
      a[i][j] = 1 - at.fraction_of(post);
      a[i][j + 1] = at.fraction_of(post);
    }
    std::vector<std::vector<long double>> m(n, std::vector<long double>(n + 1));
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t k = 0; k < n; ++k) {
        for (std::size_t s = 0; s < samples; ++s) m[i][k] += a[i][s] * a[k][s];
      }
      m[i][n] = posts[i + 5];
      for (std::size_t s = 0; s < samples; ++s) m[i][n] -= a[i][s] * dense[s];
    }
    for (std::size_t p = 0; p < n; ++p) {
      for (std::size_t i = 0; i < n; ++i) {
        if (i == p) continue;
        const long double f = m[i][p] / m[p][p];
        for (std::size_t k = p; k <= n; ++k) m[i][k] -= f * m[p][k];
      }
    }
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t s = 0; s < samples; ++s) dense[s] += a[i][s] * m[i][n] / m[i][i];
    }
    const std::vector<long double> exact = evaluate(ResampleMethod::exact);
    for (std::size_t s = 40; s + 40 < samples; ++s) {
      REQUIRE(static_cast<double>(exact[s]) == Approx(static_cast<double>(dense[s])).margin(1e-9));
    }
  }
}

TEST_CASE("a sample on a post is that post and nothing else") {
  for (double posts_per_degree : {600.0, 1200.0, 3600.0, 12.0}) {
    const AxisResampler axis({posts_per_degree, 0}, 4096, ResampleMethod::exact);
    for (std::int64_t degree : {0, 28, 185, 359}) {
      const AxisWeights w = axis.weights_for({degree * 4096, degree * 4096});
      REQUIRE(w.weights == std::vector<double>{1.0});
      REQUIRE(w.rows[0].first == degree * static_cast<std::int64_t>(posts_per_degree));
    }
  }
}

TEST_CASE("runs are as long as the ratio says, and endless ones are told") {
  const auto longest = [](LatticeAxis axis, double samples) {
    return AxisResampler(axis, samples, ResampleMethod::exact).longest_run();
  };
  constexpr auto endless = std::numeric_limits<std::int64_t>::max();
  CHECK(longest({4096, 0}, 4096) == 0);
  CHECK(longest({1024, 0}, 4096) == 0);
  CHECK(longest({1200, 0}, 4096) == 1);
  CHECK(longest({1200, 0}, 2048) == 2);
  CHECK(longest({3600, 0}, 4096) == 8);
  CHECK(longest({4096, 0.5}, 4096) == endless);
  CHECK(longest({5000, 0}, 4096) == endless);
  CHECK(longest({8192, 0}, 4096) == endless);
  CHECK_FALSE(AxisResampler({4096, 0.5}, 4096, ResampleMethod::exact).is_well_conditioned());
  CHECK(AxisResampler({4096, 0.5}, 4096, ResampleMethod::cubic).is_well_conditioned());
  CHECK(AxisResampler({4096, 0.5}, 8192, ResampleMethod::exact).is_well_conditioned());
}

}  // namespace cairn
