#include "builder/export/hillshade_shading.h"

#include <array>
#include <cmath>
#include <limits>

#include <catch2/catch.hpp>

namespace cairn {
namespace {

constexpr float kVoid = std::numeric_limits<float>::quiet_NaN();

/// A 3×3 plane that rises by `east` and `north` metres a metre, at 1000 m in the middle.
HeightField plane(double east, double north) {
  HeightField field{3, 3, {}};
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      field.metres.push_back(static_cast<float>(1000 + 10 * (east * (column - 1) + north * (1 - row))));
    }
  }
  return field;
}

const ReliefStyle kStyle{.column_spacing_m = 10, .row_spacing_m = 10};

std::array<int, 4> middle_pixel(const HeightField& field, const ReliefStyle& style = kStyle) {
  std::array<std::uint8_t, 12> row{};
  shade_row(field, 1, style, row);
  return {row[4], row[5], row[6], row[7]};
}

int brightness(const HeightField& field, const ReliefStyle& style = kStyle) {
  const auto pixel = middle_pixel(field, style);
  return pixel[0] + pixel[1] + pixel[2];
}

}  // namespace

TEST_CASE("slopes towards the north-west are bright, those away from it dark, and the others in between") {
  const int level = brightness(plane(0, 0));
  CHECK(brightness(plane(0.3, -0.3)) > level);  // falls to the north-west
  CHECK(brightness(plane(-0.3, 0.3)) < level);
  CHECK(brightness(plane(-0.3, 0.3)) < brightness(plane(0.3, 0.3)));
  CHECK(brightness(plane(0.3, 0.3)) == brightness(plane(-0.3, -0.3)));
}

TEST_CASE(
    "the light on a plane does not depend on the spacing or the exaggeration that make it the same slope") {
  ReliefStyle coarse = kStyle;
  coarse.column_spacing_m = coarse.row_spacing_m = 20;
  coarse.exaggeration = 2;
  CHECK(brightness(plane(0.2, -0.1), coarse) == brightness(plane(0.2, -0.1)));
}

TEST_CASE("a void is transparent and does not tilt its neighbours") {
  HeightField field = plane(0, 0);
  field.metres[3] = kVoid;
  CHECK(middle_pixel(field) == middle_pixel(plane(0, 0)));
  field.metres[4] = kVoid;
  CHECK(middle_pixel(field) == std::array<int, 4>{0, 0, 0, 0});
}

TEST_CASE("the sea is blue, also at 0 m, and land is not") {
  HeightField field{3, 3, std::vector<float>(9, 0.0f)};
  CHECK(middle_pixel(field)[2] > middle_pixel(field)[0] + 20);
  field.metres.assign(9, -9000.0f);
  CHECK(middle_pixel(field)[2] > middle_pixel(field)[0] + 20);
  field.metres.assign(9, 1.0f);
  CHECK(middle_pixel(field)[2] < middle_pixel(field)[1]);
  field.metres.assign(9, 9000.0f);
  CHECK(middle_pixel(field)[0] > 230);
}

TEST_CASE("four pixels become one by their alpha") {
  const std::array<std::uint8_t, 8> upper{200, 100, 0, 255, 9, 9, 9, 0},
      lower{100, 100, 100, 255, 9, 9, 9, 0};
  std::array<std::uint8_t, 4> out{};
  halve_rows(upper, lower, out);
  CHECK(out == std::array<std::uint8_t, 4>{150, 100, 50, 128});
  const std::array<std::uint8_t, 8> clear{};
  halve_rows(clear, clear, out);
  CHECK(out == std::array<std::uint8_t, 4>{0, 0, 0, 0});
}

TEST_CASE("exaggeration starts at 1 and grows with the pixel") {
  CHECK(relief_exaggeration(10) == 1);
  CHECK(relief_exaggeration(80) == 1);
  CHECK(relief_exaggeration(10000) > relief_exaggeration(1000));
}

}  // namespace cairn
