// The inner loops of image resampling: every instruction set against the portable one and against doubles.
#include "builder/imagery/texel_loops.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

constexpr float kOne = 65535;

std::vector<FloatTexel> random_pixels(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> share(0, 1);
  std::vector<FloatTexel> pixels(count);
  for (FloatTexel& pixel : pixels) {
    const float alpha = share(random) < 0.7F ? kOne : kOne * std::max(0.0F, share(random) * 2 - 1);
    pixel = FloatTexel{share(random), share(random), share(random), 1} * alpha;
  }
  return pixels;
}

LinearTexel expected_texel(const std::array<double, 4>& sum) {
  const double alpha = std::clamp(sum[3], 0.0, 65535.0);
  LinearTexel texel;
  for (std::size_t k = 0; k < 4; ++k)
    texel[k] = static_cast<std::uint16_t>(std::clamp(sum[k], 0.0, alpha) + 0.5);
  return texel;
}

void check_near(const LinearTexel& found, const LinearTexel& expected) {
  for (std::size_t k = 0; k < 4; ++k) CHECK(std::abs(found[k] - expected[k]) <= 1);
}

std::vector<KernelIsa> kernel_sets() {
  std::vector<KernelIsa> sets;
  for (const KernelIsa isa : {KernelIsa::portable, KernelIsa::avx2, KernelIsa::avx512})
    if (isa <= widest_kernel_isa()) sets.push_back(isa);
  return sets;
}

}  // namespace

TEST_CASE("rows of texels are combined the same by every instruction set, and as in doubles") {
  const std::size_t width = GENERATE(1, 7, 8, 29, 70);
  const std::vector<float> weights = {-0.07F, 0.6F, 0.55F, -0.08F, 0.0F};
  std::vector<std::vector<FloatTexel>> rows;
  std::vector<const FloatTexel*> pointers;
  for (unsigned i = 0; i < weights.size(); ++i) rows.push_back(random_pixels(width, i + 1));
  for (const auto& row : rows) pointers.push_back(row.data());
  std::vector<LinearTexel> first;
  for (const KernelIsa isa : kernel_sets()) {
    std::vector<LinearTexel> out(width);
    TexelLoops(isa).combine(pointers, weights.data(), width, out.data());
    if (first.empty()) first = out;
    CHECK(out == first);
  }
  for (std::size_t t = 0; t < width; ++t) {
    std::array<double, 4> sum{};
    for (std::size_t i = 0; i < weights.size(); ++i)
      for (int k = 0; k < 4; ++k)
        sum[static_cast<std::size_t>(k)] +=
            static_cast<double>(weights[i] * 1.0) * static_cast<double>(rows[i][t][k]);
    check_near(first[t], expected_texel(sum));
  }
}

TEST_CASE("pixels are filtered along a row the same by every instruction set, and as in doubles") {
  const double step = GENERATE(0.37, 1.0, 2.6);
  std::vector<double> positions;
  for (int t = 0; t < 21; ++t) positions.push_back(3.3 + t * step);
  const PixelTaps taps = taps_along(positions);
  const std::int64_t column = taps.first.front();
  const auto pixels = random_pixels(static_cast<std::size_t>(taps.first.back() + taps.count - column), 5);
  std::vector<FloatTexel> first;
  for (const KernelIsa isa : kernel_sets()) {
    std::vector<FloatTexel> out(positions.size());
    TexelLoops(isa).filter(pixels.data(), column, taps, out.data());
    if (first.empty()) first = out;
    for (std::size_t t = 0; t < out.size(); ++t)
      for (int k = 0; k < 4; ++k) CHECK(out[t][k] == first[t][k]);
  }
  for (std::size_t t = 0; t < first.size(); ++t) {
    double sum = 0;
    for (int i = 0; i < taps.count; ++i)
      sum += static_cast<double>(
                 taps.weights[t * static_cast<std::size_t>(taps.count) + static_cast<std::size_t>(i)]) *
             static_cast<double>(pixels[static_cast<std::size_t>(taps.first[t] - column + i)][1]);
    CHECK(static_cast<double>(first[t][1]) == Approx(sum).margin(0.1));
  }
}

TEST_CASE("the cubic between pixels is the same by every instruction set, and that of tap_weights()") {
  constexpr std::int64_t kColumns = 30, kRows = 20;
  const auto pixels = random_pixels(kColumns * kRows, 9);
  const FloatPixels image{pixels.data(), -1, -1, kColumns};
  std::mt19937 random(3);
  std::uniform_real_distribution<double> x(0, kColumns - 5), y(0, kRows - 5);
  std::vector<PlanePoint> places = {{0, 0}, {-0.0, 3.999999999}, {5, 7.5}};
  for (int i = 0; i < 200; ++i) places.push_back({x(random), y(random)});
  std::vector<LinearTexel> first;
  for (const KernelIsa isa : kernel_sets()) {
    std::vector<LinearTexel> out(places.size());
    TexelLoops(isa).interpolate(image, places, out.data());
    if (first.empty()) first = out;
    CHECK(out == first);
  }
  for (std::size_t t = 0; t < places.size(); ++t) {
    std::array<float, 4> across, down;
    tap_weights(places[t].x, 1, 4, across.data());
    tap_weights(places[t].y, 1, 4, down.data());
    std::array<double, 4> sum{};
    for (std::int64_t j = 0; j < 4; ++j)
      for (std::int64_t i = 0; i < 4; ++i) {
        const auto at = (first_tap(places[t].y, 1) + j + 1) * kColumns + first_tap(places[t].x, 1) + i + 1;
        const double weight = static_cast<double>(across[static_cast<std::size_t>(i)]) *
                              static_cast<double>(down[static_cast<std::size_t>(j)]);
        for (int k = 0; k < 4; ++k)
          sum[static_cast<std::size_t>(k)] +=
              weight * static_cast<double>(pixels[static_cast<std::size_t>(at)][k]);
      }
    check_near(first[t], expected_texel(sum));
  }
}

TEST_CASE("places within a rectangle, its sides included, are told by every instruction set") {
  const std::vector<PlanePoint> places = {{1, 2}, {4, 2}, {3, 7}, {1, 7}};
  for (const KernelIsa isa : kernel_sets()) {
    const TexelLoops rows(isa);
    CHECK(rows.all_within(places, {1, 2}, {4, 7}));
    CHECK_FALSE(rows.all_within(places, {1.001, 2}, {4, 7}));
    CHECK_FALSE(rows.all_within(places, {1, 2.001}, {4, 7}));
    CHECK_FALSE(rows.all_within(places, {1, 2}, {3.999, 7}));
    CHECK_FALSE(rows.all_within(places, {1, 2}, {4, 6.999}));
    CHECK(rows.all_within({}, {1, 2}, {4, 7}));
  }
}

TEST_CASE("halves of rows are rounded means, by every instruction set") {
  std::mt19937 random(4);
  std::vector<LinearTexel> north(2 * 37), south(2 * 37);
  for (auto* row : {&north, &south})
    for (LinearTexel& texel : *row)
      for (std::uint16_t& value : texel)
        value = static_cast<std::uint16_t>(random() % 4 == 0 ? 65535 : random());
  for (const KernelIsa isa : kernel_sets()) {
    std::vector<LinearTexel> out(37);
    TexelLoops(isa).halve(north.data(), south.data(), out.size(), out.data());
    for (std::size_t t = 0; t < out.size(); ++t)
      for (std::size_t k = 0; k < 4; ++k)
        CHECK(out[t][k] ==
              (north[2 * t][k] + north[2 * t + 1][k] + south[2 * t][k] + south[2 * t + 1][k] + 2) / 4);
  }
}

}  // namespace cairn
