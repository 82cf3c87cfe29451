#include "builder/resample/weighted_row_sum.h"

#include <random>
#include <vector>

#include <catch2/catch.hpp>

namespace cairn {

TEST_CASE("rows combine to the same bits with and without wide instructions") {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> height(-500, 9000), weight(-1, 1.5);
  for (std::size_t width : {1u, 7u, 15u, 16u, 17u, 64u, 131u}) {
    for (std::size_t count : {0u, 1u, 2u, 6u, 19u}) {
      std::vector<double> in(width * (count + 1));
      std::vector<double> weights(count);
      for (double& h : in) h = height(random);
      for (double& w : weights) w = weight(random);
      const Rows<const double> rows{in.data(), static_cast<std::ptrdiff_t>(width)};
      std::vector<double> a(width, -1), b(width, -2);
      weighted_row_sum(weights, rows, width, a.data());
      weighted_row_sum_portable(weights, rows, width, b.data());
      REQUIRE(a == b);
      std::vector<float> c(width, -1), d(width, -2);
      weighted_row_sum(weights, rows, width, c.data());
      weighted_row_sum_portable(weights, rows, width, d.data());
      REQUIRE(c == d);
      for (std::size_t i = 0; i < width; ++i) {
        double sum = 0;
        for (std::size_t k = 0; k < count; ++k) sum += weights[k] * in[k * width + i];
        REQUIRE(a[i] == sum);
      }
    }
  }
}

}  // namespace cairn
