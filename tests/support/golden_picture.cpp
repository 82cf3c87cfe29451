#include "tests/support/golden_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <vector>

#include <catch2/catch.hpp>
#include <glm/geometric.hpp>
#include <glm/vec3.hpp>
#include <png.h>

#include "runtime/viewer/png_file.h"
#include "tests/support/test_data.h"

namespace cairn::test {
namespace {

constexpr int kBlock = 4;

double linear(double byte) {
  const double c = byte / 255;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

/// L*a*b* of linear RGB, D65 (CIE 15:2004).
glm::dvec3 lab_of(const glm::dvec3& rgb) {
  const glm::dvec3 xyz((0.4124 * rgb.r + 0.3576 * rgb.g + 0.1805 * rgb.b) / 0.9505,
                       0.2126 * rgb.r + 0.7152 * rgb.g + 0.0722 * rgb.b,
                       (0.0193 * rgb.r + 0.1192 * rgb.g + 0.9505 * rgb.b) / 1.089);
  const auto f = [](double t) { return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116; };
  return {116 * f(xyz.y) - 16, 500 * (f(xyz.x) - f(xyz.y)), 200 * (f(xyz.y) - f(xyz.z))};
}

std::vector<glm::dvec3> blocks(const gl::Picture& picture) {
  std::vector<glm::dvec3> means;
  for (int row = 0; row + kBlock <= picture.height; row += kBlock) {
    for (int column = 0; column + kBlock <= picture.width; column += kBlock) {
      glm::dvec3 sum(0);
      for (int part = 0; part < kBlock * kBlock; ++part) {
        const std::uint8_t* p = picture.pixel(column + part % kBlock, row + part / kBlock);
        sum += glm::dvec3(linear(p[0]), linear(p[1]), linear(p[2]));
      }
      means.push_back(lab_of(sum / double(kBlock * kBlock)));
    }
  }
  return means;
}

}  // namespace

PictureDifference difference(const gl::Picture& a, const gl::Picture& b) {
  REQUIRE(a.width == b.width);
  REQUIRE(a.height == b.height);
  const std::vector<glm::dvec3> first = blocks(a), second = blocks(b);
  std::vector<double> all;
  double sum = 0;
  for (std::size_t i = 0; i < first.size(); ++i) {
    all.push_back(glm::distance(first[i], second[i]));
    sum += all.back();
  }
  std::sort(all.begin(), all.end());
  return {sum / static_cast<double>(all.size()), all[all.size() * 99 / 100]};
}

gl::Picture golden_picture(const std::string& name, const gl::Picture& drawn) {
  const auto path = sample_dem().parent_path() / "tests" / "golden" / "pictures" / (name + ".png");
  if (std::getenv("CAIRN_WRITE_GOLDEN")) REQUIRE(viewer::write_png(path, drawn).ok());
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  INFO(path);
  REQUIRE(png_image_begin_read_from_file(&image, path.c_str()));
  image.format = PNG_FORMAT_RGB;
  gl::Picture picture{static_cast<int>(image.width), static_cast<int>(image.height), {}};
  picture.rgb.resize(PNG_IMAGE_SIZE(image));
  REQUIRE(png_image_finish_read(&image, nullptr, picture.rgb.data(), 0, nullptr));
  return picture;
}

}  // namespace cairn::test
