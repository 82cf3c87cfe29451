#include "builder/texture_encode/texture_encode.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "tests/support/test_data.h"
#include "tests/support/test_image.h"

namespace cairn {

namespace {

using test::TestImage;

constexpr TextureFormat kFormats[] = {TextureFormat::bc1, TextureFormat::bc3, TextureFormat::bc7};
constexpr TextureQuality kQualities[] = {TextureQuality::fast, TextureQuality::normal, TextureQuality::best};

std::vector<std::byte> encoded(const TestImage& image, TextureFormat format, TextureQuality quality) {
  std::vector<std::byte> out;
  encode_texture(format, quality, image.rgba, image.width, image.height, out);
  return out;
}

std::vector<std::uint8_t> decoded(const TestImage& image, TextureFormat format, TextureQuality quality) {
  std::vector<std::uint8_t> rgba(image.rgba.size());
  REQUIRE(decode_texture(format, encoded(image, format, quality), image.width, image.height, rgba).ok());
  return rgba;
}

// One 4×4 block a texel of `colours`, each of one colour.
TestImage flat_blocks(const std::vector<std::array<std::uint8_t, 4>>& colours) {
  TestImage image{static_cast<int>(colours.size()) * 4, 4, {}};
  for (int y = 0; y < 4; ++y) {
    for (const auto& colour : colours) {
      for (int x = 0; x < 4; ++x) image.rgba.insert(image.rgba.end(), colour.begin(), colour.end());
    }
  }
  return image;
}

// The least error with which a block of four colours can show one 8-bit value.
int least_error(int value, int bits) {
  int least = 255;
  for (int a = 0; a < 1 << bits; ++a) {
    for (int b = 0; b < 1 << bits; ++b) {
      const int wide_a = a << (8 - bits) | a >> (2 * bits - 8),
                wide_b = b << (8 - bits) | b >> (2 * bits - 8);
      least = std::min(least, std::abs((2 * wide_a + wide_b + 1) / 3 - value));
    }
  }
  return least;
}

}  // namespace

TEST_CASE("every instruction set gives the same bytes") {
  if (widest_kernel_isa() == KernelIsa::portable) {
    WARN("SKIPPED, nothing was checked: this CPU has only the portable kernels");
    return;
  }
  std::vector<TestImage> images = {test::landscape(252, 61, 6, 1), test::noise(64, 64, 2),
                                   test::noise(4, 4, 3)};
  images.push_back(test::landscape(128, 64, 0.5, 4));
  for (const TestImage& image : images) {
    for (const TextureFormat format : kFormats) {
      for (const TextureQuality quality : kQualities) {
        std::vector<std::byte> portable;
        encode_texture_with(KernelIsa::portable, format, quality, image.rgba, image.width, image.height,
                            portable);
        for (const KernelIsa isa : {KernelIsa::avx2, KernelIsa::avx512}) {
          if (isa > widest_kernel_isa()) continue;
          std::vector<std::byte> wide;
          encode_texture_with(isa, format, quality, image.rgba, image.width, image.height, wide);
          CHECK(portable == wide);
        }
      }
    }
  }
}

TEST_CASE("the errors of BC1 blocks are those of the decoder, by every instruction set") {
  std::mt19937 random(11);
  for (TestImage image : {test::landscape(252, 60, 6, 1), test::noise(64, 64, 2), test::noise(4, 4, 3)}) {
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
    std::vector<std::byte> any(texture_bytes(TextureFormat::bc1, image.width, image.height));
    for (std::byte& b : any) b = static_cast<std::byte>(random());
    for (const auto& blocks : {any, encoded(image, TextureFormat::bc1, TextureQuality::best)}) {
      std::vector<std::uint8_t> rgba(image.rgba.size());
      REQUIRE(decode_texture(TextureFormat::bc1, blocks, image.width, image.height, rgba).ok());
      std::vector<std::uint32_t> expected(blocks.size() / 8);
      const auto width = static_cast<std::size_t>(image.width);
      for (std::size_t i = 0; i < rgba.size(); ++i) {
        const int off = i % 4 == 3 ? 0 : rgba[i] - image.rgba[i];
        const std::size_t x = i / 4 % width, y = i / 4 / width;
        expected[y / 4 * (width / 4) + x / 4] += static_cast<std::uint32_t>(off * off);
      }
      for (const KernelIsa isa : {KernelIsa::portable, KernelIsa::avx2, KernelIsa::avx512}) {
        if (isa > widest_kernel_isa()) continue;
        std::vector<std::uint32_t> errors;
        bc1_errors_with(isa, image.rgba, image.width, image.height, blocks, errors);
        CHECK(errors == expected);
      }
    }
  }
}

TEST_CASE("a better quality is better, and none is poor") {
  const TestImage image = test::landscape(512, 256, 8, 5);
  for (const TextureFormat format : kFormats) {
    const double fast = test::psnr_db(image, format, encoded(image, format, TextureQuality::fast));
    const double normal = test::psnr_db(image, format, encoded(image, format, TextureQuality::normal));
    const double best = test::psnr_db(image, format, encoded(image, format, TextureQuality::best));
    CAPTURE(fast, normal, best);
    CHECK(fast > 36.0);
    CHECK(normal > fast);
    CHECK(best > normal);
  }
}

TEST_CASE("real photos keep the promised quality", "[data]") {
  const auto data = test::real_data();
  if (!data) return;
  const TestImage image = test::photo(*data / "imagery/swellendam_3420B_2010_328_RGB_LATLNG.tif", 4096, 4096);
  REQUIRE(image.width == 1098);
  CHECK(test::psnr_db(image, TextureFormat::bc1, encoded(image, TextureFormat::bc1, TextureQuality::fast)) >=
        34.5);
  CHECK(test::psnr_db(image, TextureFormat::bc1,
                      encoded(image, TextureFormat::bc1, TextureQuality::normal)) >= 35.8);
  CHECK(test::psnr_db(image, TextureFormat::bc1, encoded(image, TextureFormat::bc1, TextureQuality::best)) >=
        36.2);
  CHECK(test::psnr_db(image, TextureFormat::bc7,
                      encoded(image, TextureFormat::bc7, TextureQuality::normal)) >= 38.5);
}

TEST_CASE("a block of one colour comes as near to it as the format allows") {
  std::mt19937 random(6);
  std::vector<std::array<std::uint8_t, 4>> colours;
  for (unsigned value = 0; value < 256; ++value) {
    const auto grey = static_cast<std::uint8_t>(value);
    colours.push_back({grey, grey, grey, 255});
    colours.push_back({grey, static_cast<std::uint8_t>(random()), static_cast<std::uint8_t>(random()), 255});
  }
  const TestImage image = flat_blocks(colours);
  for (const TextureFormat format : kFormats) {
    for (const TextureQuality quality : kQualities) {
      const auto rgba = decoded(image, format, quality);
      for (std::size_t i = 0; i < rgba.size(); ++i) {
        const int off = std::abs(rgba[i] - image.rgba[i]);
        const bool exact = i % 4 == 3 || format == TextureFormat::bc7;
        const int allowed = exact ? 0 : least_error(image.rgba[i], i % 4 == 1 ? 6 : 5);
        if (off <= allowed) continue;
        CAPTURE(i, off, allowed, static_cast<int>(quality));
        FAIL();
      }
    }
  }
}

TEST_CASE("a block of two colours that the format has is exact at the best quality") {
  std::mt19937 random(7);
  TestImage image{4, 4, {}};
  for (int n = 0; n < 200; ++n) {
    std::array<std::array<std::uint8_t, 4>, 2> colours;
    for (auto& colour : colours) {
      const unsigned r = random() & 31, g = random() & 63, b = random() & 31;
      colour = {static_cast<std::uint8_t>(r << 3 | r >> 2), static_cast<std::uint8_t>(g << 2 | g >> 4),
                static_cast<std::uint8_t>(b << 3 | b >> 2), 255};
    }
    image.rgba.clear();
    for (int i = 0; i < 16; ++i) {
      const auto& colour = colours[random() & 1];
      image.rgba.insert(image.rgba.end(), colour.begin(), colour.end());
    }
    REQUIRE(decoded(image, TextureFormat::bc1, TextureQuality::best) == image.rgba);
  }
}

TEST_CASE("a BC1 texel is a hole where alpha is under 128, and opaque elsewhere") {
  TestImage image = test::landscape(64, 64, 4, 8);
  std::mt19937 random(9);
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    const bool near_the_edge = i / 4 % 64 < 20;
    if (near_the_edge) image.rgba[i + 3] = static_cast<std::uint8_t>(random() & 255);
  }
  for (const TextureQuality quality : kQualities) {
    const auto rgba = decoded(image, TextureFormat::bc1, quality);
    double squares = 0;
    for (std::size_t i = 0; i < rgba.size(); i += 4) {
      REQUIRE(rgba[i + 3] == (image.rgba[i + 3] < 128 ? 0 : 255));
      if (rgba[i + 3] == 0) continue;
      for (std::size_t c = 0; c < 3; ++c) squares += std::pow(rgba[i + c] - image.rgba[i + c], 2);
    }
    CHECK(squares / static_cast<double>(rgba.size()) < 20);
  }
}

TEST_CASE("a BC1 block without any opaque texel is empty") {
  const TestImage image{4, 4, std::vector<std::uint8_t>(64, 90)};
  CHECK(decoded(image, TextureFormat::bc1, TextureQuality::normal) == std::vector<std::uint8_t>(64, 0));
}

TEST_CASE("BC3 keeps alphas to their steps, and 0 and 255 exactly where there is nothing else") {
  TestImage image = test::landscape(64, 64, 4, 10);
  for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
    image.rgba[i + 3] = i / 256 < 32 ? static_cast<std::uint8_t>(i / 256 * 8) : (i / 4 % 3 ? 255 : 0);
  }
  for (const TextureQuality quality : kQualities) {
    const auto rgba = decoded(image, TextureFormat::bc3, quality);
    for (std::size_t i = 3; i < rgba.size(); i += 4) {
      const int off = std::abs(rgba[i] - image.rgba[i]);
      REQUIRE(off <= (i / 256 < 32 ? 2 : 0));
    }
  }
}

TEST_CASE("BC7 keeps an opaque image opaque, and blends of alpha near") {
  TestImage image = test::landscape(64, 64, 4, 13);
  for (const TextureQuality quality : kQualities) {
    const auto rgba = decoded(image, TextureFormat::bc7, quality);
    for (std::size_t i = 3; i < rgba.size(); i += 4) REQUIRE(rgba[i] == 255);
  }
  for (std::size_t i = 3; i < image.rgba.size(); i += 4)
    image.rgba[i] = static_cast<std::uint8_t>(255 - i / 4 % 64 * 3);
  for (const TextureQuality quality : kQualities) {
    CHECK(test::psnr_db(image, TextureFormat::bc7, encoded(image, TextureFormat::bc7, quality), 3, 4) > 38);
  }
}

TEST_CASE("an image of any size is that image with its last column and row repeated") {
  const TestImage wide = test::landscape(64, 16, 5, 11);
  for (const auto& [width, height] :
       {std::pair{1, 1}, std::pair{3, 2}, std::pair{35, 13}, std::pair{61, 5}}) {
    TestImage cut{width, height, {}}, padded{(width + 3) / 4 * 4, (height + 3) / 4 * 4, {}};
    for (TestImage* image : {&cut, &padded}) {
      for (int y = 0; y < image->height; ++y) {
        for (int x = 0; x < image->width; ++x) {
          const int texel = std::min(y, height - 1) * wide.width + std::min(x, width - 1);
          for (int c = 0; c < 4; ++c)
            image->rgba.push_back(wide.rgba[static_cast<std::size_t>(4 * texel + c)]);
        }
      }
    }
    for (const TextureFormat format : kFormats) {
      CHECK(encoded(cut, format, TextureQuality::normal) == encoded(padded, format, TextureQuality::normal));
    }
  }
}

TEST_CASE("blocks are appended") {
  const TestImage image = test::noise(8, 8, 12);
  std::vector<std::byte> out(3, std::byte{42});
  encode_texture(TextureFormat::bc1, TextureQuality::fast, image.rgba, 8, 8, out);
  REQUIRE(out.size() == 3 + 32);
  CHECK(out[2] == std::byte{42});
  CHECK(std::equal(out.begin() + 3, out.end(),
                   encoded(image, TextureFormat::bc1, TextureQuality::fast).begin()));
}

}  // namespace cairn
